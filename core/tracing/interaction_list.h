// SPDX-License-Identifier: Apache-2.0
//
// A bounce sequence written out for one wavelength: every surface the light meets, in order, with
// the indices on both sides. The tracer runs down this list and knows nothing else of the lens. A
// sensor that reflects is an interaction like any other, with the surface number
// Lens::sensor_index(); the sensor that the light ends on is none.
#pragma once

#include <vector>

#include "core/optics/lens.h"
#include "core/tracing/bounce_sequence.h"

namespace flare {

enum class InteractionKind { kRefract, kReflect, kStop };

struct Interaction {
    InteractionKind kind = InteractionKind::kRefract;
    int surface = 0;
    bool forward = true;  // the light meets the surface travelling from its front to its back
    double vertex_z_mm = 0.0;
    SurfaceShape shape;
    double semi_diameter_mm = 0.0;
    double n_in = 1.0;               // medium the light comes from
    double n_out = 1.0;              // medium behind the interface (also for a reflection)
    double absorption_per_mm = 0.0;  // of the medium the light comes from
};

struct InteractionList {
    std::vector<Interaction> steps;
    double sensor_z_mm = 0.0;
    double wavelength_nm = 0.0;
    int stop_crossings = 0;
};

// Requires a sound sequence (CheckSequence).
InteractionList WriteOut(const Lens& lens, const BounceSequence& sequence, double wavelength_nm);

// Reflectance or transmittance of one step, unpolarised, at incidence cosine `cos_in`.
Reflection ReflectionAt(const Lens& lens, const Interaction& step, double cos_in,
                        double wavelength_nm);

}  // namespace flare
