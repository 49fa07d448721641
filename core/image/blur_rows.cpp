// SPDX-License-Identifier: Apache-2.0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "core/image/blur_rows.cpp"
#include <hwy/foreach_target.h>
// foreach_target.h must come before highway.h.
#include <hwy/highway.h>

#include "core/image/blur_rows-inl.h"

#if HWY_ONCE

namespace flare {

HWY_EXPORT(SumRows);

void SumBlurRows(std::span<const BlurRow> rows, float* sums) {
    HWY_DYNAMIC_DISPATCH(SumRows)(rows, sums);
}

}  // namespace flare
#endif  // HWY_ONCE
