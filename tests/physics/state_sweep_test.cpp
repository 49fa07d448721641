// SPDX-License-Identifier: Apache-2.0
//
// Zoom and focus move ghosts continuously: over a sweep from end to end no ghost's centroid jumps,
// and with twice as many steps the largest step is about half as long. A jump would keep its length
// however fine the steps.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>

#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/optics/lens_state.h"
#include "core/render/ghost_estimate.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

struct Sweep {
    const char* name;
    const char* lens;
    int every;                               // which of the lens's ghosts are followed
    std::function<LensState(double)> state;  // over 0 ... 1
    double field_deg;
};

struct Place {
    double flux_mm2 = 0.0;
    Vec2d centroid_mm{0.0, 0.0};
};

// Flux and centroid of every followed ghost, from meshes of exact rays, wide open.
std::vector<Place> PlacesOf(const Sweep& sweep, double at, ThreadPool& threads) {
    const auto base = testing::LibraryLens(sweep.lens);
    const Result<LensInState> set = SetState(base, sweep.state(at));
    FLARE_CHECK(set.ok());
    const Lens& lens = *set->lens;
    const double rim =
        lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm;
    const Iris iris({}, rim, rim);
    const LightBundle bundle(lens, RadiansFromDegrees(sweep.field_deg), 0.0);
    const TransmissionTables tables(lens, {kLineD}, threads);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(lens);
    std::vector<Place> places((sequences.size() + static_cast<std::size_t>(sweep.every) - 1) /
                              static_cast<std::size_t>(sweep.every));
    threads.For(static_cast<int>(places.size()), [&](int n) {
        MeshSpec spec;
        spec.sequence = sequences[static_cast<std::size_t>(n * sweep.every)];
        spec.field_rad = bundle.field_rad();
        spec.wavelengths_nm = {kLineD};
        spec.cells = 24;
        spec.patch_cells = 4;
        spec.position_tolerance_mm = 0.1;
        spec.mask_tolerance = 0.02;
        const GhostSurface surface(std::make_shared<const GhostMesh>(BuildMesh(lens, spec)),
                                   lens.sensor_gap_mm());
        const GhostEstimate estimate = EstimateOf(surface, bundle, lens, tables, iris, {});
        places[static_cast<std::size_t>(n)] = {estimate.flux_mm2, estimate.centroid_mm};
    });
    return places;
}

struct LargestStep {
    double mm = 0.0;
    std::size_t ghost = 0;
};

// Of ghosts that hold a thousandth of the followed light or more, at both ends of the step.
LargestStep StepsOf(const std::vector<std::vector<Place>>& sweep, std::size_t stride) {
    LargestStep largest;
    for (std::size_t k = 0; k + stride < sweep.size(); k += stride) {
        double total = 0.0;
        for (const Place& place : sweep[k]) total += place.flux_mm2;
        for (std::size_t n = 0; n < sweep[k].size(); ++n) {
            const Place& a = sweep[k][n];
            const Place& b = sweep[k + stride][n];
            if (std::min(a.flux_mm2, b.flux_mm2) < 1e-3 * total) continue;
            const double step = (b.centroid_mm - a.centroid_mm).length();
            if (step > largest.mm) largest = {step, n};
        }
    }
    return largest;
}

class StateSweep : public ::testing::TestWithParam<Sweep> {};

TEST_P(StateSweep, MovesGhostsContinuously) {
    const Sweep& sweep = GetParam();
    ThreadPool threads(2);
    constexpr int kSteps = 100;
    std::vector<std::vector<Place>> places;
    for (int k = 0; k <= kSteps; ++k) {
        places.push_back(PlacesOf(sweep, static_cast<double>(k) / kSteps, threads));
    }
    const LargestStep fine = StepsOf(places, 1);
    const LargestStep coarse = StepsOf(places, 2);
    std::printf("%s: largest centroid step %.4f mm in 100 steps (ghost %zu), %.4f mm in 50\n",
                sweep.name, fine.mm, fine.ghost, coarse.mm);
    RecordProperty("largest_step_mm", std::to_string(fine.mm));
    EXPECT_GT(fine.mm, 0.0);
    EXPECT_LT(fine.mm, 0.75 * coarse.mm);
}

LensState Focused(double per_m) {
    LensState state;
    if (per_m > 0.0) state.focus_m = 1.0 / per_m;
    return state;
}

LensState FocusedToHalfAMetre(double at) {
    return Focused(2.0 * at);
}

LensState FocusedByTable(double at) {
    return Focused(1.15 * at);
}

LensState Zoomed(double at) {
    LensState state;
    state.zoom_mm = 72.1 * std::pow(194.0 / 72.1, at);
    return state;
}

INSTANTIATE_TEST_SUITE_P(Library, StateSweep,
                         ::testing::Values(
                             // The whole lens moves.
                             Sweep{"unit_focus", "tronnier-double-gauss-50mm-f2", 1,
                                   FocusedToHalfAMetre, 5.0},
                             // Inner focusing, to the nearest of the file's table.
                             Sweep{"inner_focus", "canon-rf-85mm-f1_2", 12, FocusedByTable, 5.0},
                             Sweep{"zoom", "canon-zoom-70-200mm-f2_8", 24, Zoomed, 3.0}),
                         [](const auto& sweep) { return std::string(sweep.param.name); });

}  // namespace
}  // namespace flare
