// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/ghost_ringing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"

namespace flare {
namespace {

// First bright ring of Airy's pattern, in lambda |B2| / a.
constexpr double kAiryRing = 0.817;
constexpr double kLeastFringe_px = 0.5;

// Maxima before the bandwidth has moved a fringe onto its neighbour: v^2 grows by 4 from one to the
// next and is 1.5 at the first, and v^2 scales with 1 / lambda.
double FringesOf(double relative_bandwidth) {
    if (relative_bandwidth <= 0.0) return std::numeric_limits<double>::infinity();
    return (2.0 / relative_bandwidth + 2.5) / 4.0;
}

}  // namespace

GhostRinging RingingOf(const ParaxialPath& path, std::size_t crossing,
                       const RingingConditions& conditions) {
    FLARE_CHECK(crossing < path.front_to_stop.size() && conditions.aperture_radius_mm > 0.0);
    const Abcd& whole = path.front_to_sensor;
    const Abcd& first = path.front_to_stop[crossing];
    const Abcd& second = path.stop_to_sensor[crossing];
    const double lambda = conditions.wavelength_nm * 1e-6;
    const double a = conditions.aperture_radius_mm;

    GhostRinging ringing;
    ringing.fringes = FringesOf(conditions.relative_bandwidth);
    if (second.b == 0.0 || first.a == 0.0) {
        ringing.fresnel_number = std::numeric_limits<double>::infinity();
        ringing.reason = RingingReason::kStopInFocus;
        return ringing;
    }
    ringing.m = whole.a / first.a;
    ringing.z_eff_mm = second.b * first.a / whole.a;
    ringing.fresnel_number = a * a / (lambda * std::abs(ringing.z_eff_mm));
    // |m| sqrt(lambda |z_eff| / 2) = sqrt(lambda |B2 A / A1| / 2); in focus the aperture's own
    // ring.
    const double edge = kFirstFringe * std::sqrt(0.5 * lambda * std::abs(second.b * ringing.m));
    const double ring = kAiryRing * lambda * std::abs(second.b) / a;
    ringing.fringe_mm = std::max(edge, ring);
    // d(sensor) / d(angle) with the place in the stop held.
    ringing.blur_mm = std::abs(whole.b - whole.a * first.b / first.a) * conditions.source_rad;

    if (ringing.blur_mm >= ringing.fringe_mm) {
        ringing.reason = RingingReason::kSource;
    } else if (ringing.fringe_mm < kLeastFringe_px * conditions.pixel_mm) {
        ringing.reason = RingingReason::kPixel;
    } else if (ringing.fringes < 1.0) {
        ringing.reason = RingingReason::kBandwidth;
    } else {
        ringing.model = ringing.fresnel_number > kManyFresnelZones ? RingingModel::kEdgeProfile
                                                                   : RingingModel::kPropagation;
    }
    return ringing;
}

}  // namespace flare
