// SPDX-License-Identifier: Apache-2.0
//
// The kernel of passage_columns.cpp, compiled once for each instruction set.

#if defined(FLARE_PASSAGE_COLUMNS_INL_) == defined(HWY_TARGET_TOGGLE)
#ifdef FLARE_PASSAGE_COLUMNS_INL_
#undef FLARE_PASSAGE_COLUMNS_INL_
#else
#define FLARE_PASSAGE_COLUMNS_INL_
#endif

#include <hwy/highway.h>

#include "core/mesh/passage_columns.h"

HWY_BEFORE_NAMESPACE();
namespace flare {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// The product of all polynomials, ray by ray. `weights` are those of the nodes.
void MultiplyFits(const PathInColumns::Fit* fits, std::size_t count, const float* weights,
                  std::size_t nodes, const PassageColumns& rays, float* out) {
    const hn::ScalableTag<float> tag;
    const std::size_t node_stride = rays.passages * rays.stride;
    for (std::size_t k = 0; k < rays.stride; k += hn::Lanes(tag)) {
        auto product = hn::Set(tag, 1.0F);
        for (std::size_t f = 0; f < count; ++f) {
            const PathInColumns::Fit& fit = fits[f];
            const float* const row = rays.values.data() + fit.step * rays.stride + k;
            auto value = hn::Mul(hn::Set(tag, weights[0]), hn::LoadU(tag, row));
            for (std::size_t n = 1; n < nodes; ++n) {
                value = hn::MulAdd(hn::Set(tag, weights[n]), hn::LoadU(tag, row + n * node_stride),
                                   value);
            }
            value = hn::Min(value, hn::Set(tag, 1.0F));
            if (fit.root) value = hn::Sqrt(hn::Max(value, hn::Zero(tag)));
            const auto x =
                hn::Mul(hn::Sub(value, hn::Set(tag, fit.middle)), hn::Set(tag, fit.inverse_half));
            auto factor = hn::Set(tag, fit.terms[PathInColumns::kTerms - 1]);
            for (std::size_t t = PathInColumns::kTerms - 1; t-- > 0;)
                factor = hn::MulAdd(factor, x, hn::Set(tag, fit.terms[t]));
            product = hn::Mul(product, factor);
        }
        hn::StoreU(product, tag, out + k);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace flare
HWY_AFTER_NAMESPACE();

#endif  // per target
