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

// The box of the bundle's plane that holds the rays which arrive; v >= 0 only where the lens, seen
// from the light, is symmetric in v.
struct ArrivalBox {
    double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;
    bool empty = true;
};

// Looks at `side` rays along u and as close ones along v within `in`, and widens what it finds by
// three of their steps.
inline ArrivalBox LookForArrivals(const InteractionList& list, const LightBundle& bundle,
                                  const TraceOptions& options, const ArrivalBox& in, int side) {
    const int rows = bundle.mirror_symmetric() ? side / 2 : side;
    const double du = (in.u1 - in.u0) / side;
    const double dv = (in.v1 - in.v0) / rows;
    ArrivalBox box{1e300, -1e300, 1e300, -1e300, true};
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= side; ++i) {
            const double u = in.u0 + i * du;
            const double v = in.v0 + j * dv;
            const TraceResult ray = TraceRay(list, bundle.At(u, v), options, nullptr);
            if (ray.fate != RayFate::kArrived) continue;
            box = {std::min(box.u0, u - 3.0 * du), std::max(box.u1, u + 3.0 * du),
                   std::min(box.v0, v - 3.0 * dv), std::max(box.v1, v + 3.0 * dv), false};
        }
    }
    if (bundle.mirror_symmetric()) box.v0 = 0.0;
    return box;
}

// `side` rays along u and half as many (as many without symmetry) along v over the part of the
// bundle where a first look finds rays that pass. `each(sensor place, flux)` is called for every
// ray that arrives; the light's mirror symmetry, where it has one, doubles its flux.
template <class Each>
CountedFlux CountFlux(const Lens& lens, const LightBundle& bundle, const BounceSequence& sequence,
                      double wavelength_nm, const Iris& iris, int side, Each each) {
    const InteractionList list = WriteOut(lens, sequence, wavelength_nm);
    const TraceOptions options{true, &iris, false};
    const bool mirrored = bundle.mirror_symmetric();
    const double half = bundle.half_width();
    ArrivalBox box{bundle.centre_u() - half, bundle.centre_u() + half, mirrored ? 0.0 : -half, half,
                   false};
    // Fine enough for the small separate parts that a wide front element's regions may have.
    const int first_look = std::max(256, 2 * static_cast<int>(5.0 * half));
    for (const int look : {first_look, 96}) {
        box = LookForArrivals(list, bundle, options, box, look);
        if (box.empty) return {};
    }
    const auto [u0, u1, v0, v1, empty] = box;
    CountedFlux counted;
    const int rows = mirrored ? side / 2 : side;
    const double du = (u1 - u0) / side;
    const double dv = (v1 - v0) / rows;
    RayRecord record;
    for (int j = 0; j < rows; ++j) {
        for (int i = 0; i < side; ++i) {
            // Rows are shifted against each other, so that edges parallel to the grid do not beat.
            const double shift = static_cast<double>((j * 7) % 16) / 16.0;
            const double u = u0 + (i + shift) * du;
            const double v = v0 + (j + 0.5) * dv;
            const TraceResult ray = TraceRay(list, bundle.At(u, v), options, &record);
            if (ray.fate != RayFate::kArrived) continue;
            ++counted.arrived;
            const double flux = PathWeight(lens, list, record) * bundle.FluxDensity(u, v) *
                                (mirrored ? 2.0 : 1.0) * du * dv;
            counted.flux_mm2 += flux;
            counted.centroid_mm += ray.sensor_mm * flux;
            each(ray.sensor_mm, flux);
        }
    }
    if (counted.flux_mm2 > 0.0) counted.centroid_mm /= counted.flux_mm2;
    // The other half of a symmetric light: across the plane of symmetry the sum is 0.
    if (mirrored) {
        const Vec2d along = bundle.Meridional(1.0, 0.0);
        counted.centroid_mm = along * counted.centroid_mm.dot(along);
    }
    return counted;
}

}  // namespace flare::testing
