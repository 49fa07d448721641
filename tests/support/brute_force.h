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

// The box of the bundle's plane, v >= 0, that holds the rays which arrive.
struct ArrivalBox {
    double u0 = 0.0, u1 = 0.0, v1 = 0.0;
    bool empty = true;
};

// Looks at `side` x side / 2 rays within `in` and widens what it finds by three of their steps.
inline ArrivalBox LookForArrivals(const InteractionList& list, const LightBundle& bundle,
                                  const TraceOptions& options, const ArrivalBox& in, int side) {
    const double du = (in.u1 - in.u0) / side;
    const double dv = in.v1 / (side / 2);
    ArrivalBox box{1e300, -1e300, 0.0, true};
    for (int j = 0; j <= side / 2; ++j) {
        for (int i = 0; i <= side; ++i) {
            const double u = in.u0 + i * du;
            const double v = j * dv;
            const TraceResult ray = TraceRay(list, bundle.At(u, v), options, nullptr);
            if (ray.fate != RayFate::kArrived) continue;
            box = {std::min(box.u0, u - 3.0 * du), std::max(box.u1, u + 3.0 * du),
                   std::max(box.v1, v + 3.0 * dv), false};
        }
    }
    return box;
}

// `side` x side / 2 rays over the part of the bundle where a first look finds rays that pass.
// `each(sensor place, flux)` is called for every ray that arrives; the light's mirror symmetry
// doubles its flux.
template <class Each>
CountedFlux CountFlux(const Lens& lens, const LightBundle& bundle, const BounceSequence& sequence,
                      double wavelength_nm, const Iris& iris, int side, Each each) {
    const InteractionList list = WriteOut(lens, sequence, wavelength_nm);
    const TraceOptions options{true, &iris, false};
    const double half = bundle.half_width();
    ArrivalBox box{bundle.centre_u() - half, bundle.centre_u() + half, half, false};
    // Fine enough for the small separate parts that a wide front element's regions may have.
    const int first_look = std::max(256, 2 * static_cast<int>(5.0 * half));
    for (const int look : {first_look, 96}) {
        box = LookForArrivals(list, bundle, options, box, look);
        if (box.empty) return {};
    }
    const auto [u0, u1, v1, empty] = box;
    CountedFlux counted;
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
