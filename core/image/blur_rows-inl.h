// SPDX-License-Identifier: Apache-2.0
//
// The kernel of blur_rows.cpp, compiled once for each instruction set.
#if defined(FLARE_BLUR_ROWS_TOGGLE_) == defined(HWY_TARGET_TOGGLE)
#ifdef FLARE_BLUR_ROWS_TOGGLE_
#undef FLARE_BLUR_ROWS_TOGGLE_
#else
#define FLARE_BLUR_ROWS_TOGGLE_
#endif

#include <cstddef>

#include "core/image/blur_rows.h"

HWY_BEFORE_NAMESPACE();
namespace flare {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

void SumRows(std::span<const BlurRow> rows, float* sums) {
    constexpr int kVectors = 4;
    const hn::CappedTag<float, kBlurRun / kVectors> d;
    const auto lanes = static_cast<int>(hn::Lanes(d));
    for (int k = 0; k < kBlurRun; k += kVectors * lanes) {
        auto a = hn::Zero(d);
        auto b = hn::Zero(d);
        auto c = hn::Zero(d);
        auto e = hn::Zero(d);
        for (const BlurRow& row : rows) {
            for (int i = row.first; i < row.end; ++i) {
                const auto weight = hn::Set(d, row.weights[i]);
                const float* const at = row.light + (k - i);
                a = hn::Add(a, hn::Mul(weight, hn::LoadU(d, at)));
                b = hn::Add(b, hn::Mul(weight, hn::LoadU(d, at + lanes)));
                c = hn::Add(c, hn::Mul(weight, hn::LoadU(d, at + 2 * lanes)));
                e = hn::Add(e, hn::Mul(weight, hn::LoadU(d, at + 3 * lanes)));
            }
        }
        hn::StoreU(a, d, sums + k);
        hn::StoreU(b, d, sums + k + lanes);
        hn::StoreU(c, d, sums + k + 2 * lanes);
        hn::StoreU(e, d, sums + k + 3 * lanes);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace flare
HWY_AFTER_NAMESPACE();

#endif  // FLARE_BLUR_ROWS_TOGGLE_
