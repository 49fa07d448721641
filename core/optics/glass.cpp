// SPDX-License-Identifier: Apache-2.0
#include "core/optics/glass.h"

#include "core/base/check.h"

namespace flare {

Glass Glass::FromNdVd(double nd, std::optional<double> vd) {
    FLARE_CHECK(nd >= 1.0);
    if (!vd.has_value() || nd == 1.0) return {nd, 0.0};
    FLARE_CHECK(*vd > 0.0);
    const double inverse_square_f_minus_c = 1.0 / (kLineF * kLineF) - 1.0 / (kLineC * kLineC);
    const double b = (nd - 1.0) / (*vd * inverse_square_f_minus_c);
    return {nd - b / (kLineD * kLineD), b};
}

}  // namespace flare
