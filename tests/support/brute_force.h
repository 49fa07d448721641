// SPDX-License-Identifier: Apache-2.0
//
// The flux of one ghost by counting: a grid of exactly traced, clipped rays over the light's
// bundle, each worth its weight times the light of its cell. No mesh, no interpolation, no polygon.
#pragma once

#include <algorithm>

#include "core/optics/iris.h"
#include "core/tracing/light_bundle.h"
#include "core/tracing/trace_reference.h"

namespace flare::testing {

struct CountedFlux {
    double flux_mm2 = 0.0;
    Vec2d centroid_mm{0.0, 0.0};
    int arrived = 0;
};

// `side` rays a side over the rectangle of the bundle where a coarse look finds rays that pass.
// `each(sensor place, flux)` is called for every ray that arrives.
template <class Each>
CountedFlux CountFlux(const Lens& lens, const LightBundle& bundle, const BounceSequence& sequence,
                      double wavelength_nm, const Iris& iris, int side, Each each) {
    const InteractionList list = WriteOut(lens, sequence, wavelength_nm);
    const TraceOptions options{true, &iris, false};
    constexpr int kLook = 256;
    const double step = 2.0 * bundle.half_width() / kLook;
    double u0 = 1e300, u1 = -1e300, v1 = -1e300;
    for (int j = 0; j <= kLook / 2; ++j) {
        for (int i = 0; i <= kLook; ++i) {
            const double u = bundle.centre_u() - bundle.half_width() + i * step;
            const double v = j * step;
            if (TraceRay(list, bundle.At(u, v), options, nullptr).fate != RayFate::kArrived)
                continue;
            u0 = std::min(u0, u - step);
            u1 = std::max(u1, u + step);
            v1 = std::max(v1, v + step);
        }
    }
    CountedFlux counted;
    if (u1 < u0) return counted;
    // Mirror symmetry: half the plane, twice the light.
    const double du = (u1 - u0) / side;
    const double dv = v1 / (side / 2);
    RayRecord record;
    for (int j = 0; j < side / 2; ++j) {
        for (int i = 0; i < side; ++i) {
            // Rows are shifted against each other, so that edges parallel to the grid do not beat.
            const double shift = static_cast<double>((j * 7) % 16) / 16.0;
            const double u = u0 + (i + shift) * du;
            const double v = (j + 0.5) * dv;
            const TraceResult ray = TraceRay(list, bundle.At(u, v), options, &record);
            if (ray.fate != RayFate::kArrived) continue;
            ++counted.arrived;
            const double flux =
                PathWeight(lens, list, record) * bundle.FluxDensity(u, v) * 2.0 * du * dv;
            counted.flux_mm2 += flux;
            counted.centroid_mm.x += flux * ray.sensor_mm.x;
            each(ray.sensor_mm, flux);
        }
    }
    if (counted.flux_mm2 > 0.0) counted.centroid_mm /= counted.flux_mm2;
    return counted;
}

}  // namespace flare::testing
