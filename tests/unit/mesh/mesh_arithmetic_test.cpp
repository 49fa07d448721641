// SPDX-License-Identifier: Apache-2.0
//
// Meshes traced in floats, many rays at once, against the same meshes in doubles, ray by ray.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/parallel.h"
#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/spectrum/wavelength_plan.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

constexpr double kPixel_mm = 36.0 / 1920.0;

MeshSpec SpecOf(const Lens& lens, BounceSequence sequence, double field_deg) {
    MeshSpec spec;
    spec.sequence = std::move(sequence);
    spec.field_rad = RadiansFromDegrees(field_deg);
    spec.azimuth_rad = lens.rotational() ? 0.0 : 0.4;
    spec.wavelengths_nm = ChebyshevNodes(405.0, 705.0, 3);
    spec.cells = 24;
    spec.position_tolerance_mm = 0.03;
    spec.mask_tolerance = 0.01;
    return spec;
}

struct Case {
    const char* name;
    double field_deg;
    double allowed_px;  // p99.9
};

// Those that draw something, by themselves and not by a patch.
std::vector<std::uint8_t> CornersOfUsedCells(const MeshGrid& grid) {
    std::vector<std::uint8_t> used(grid.alive.size(), 0);
    for (int j = 0; j + 1 < grid.nv; ++j) {
        for (int i = 0; i + 1 < grid.nu; ++i) {
            if (grid.cells[grid.Cell(i, j)] != CellUse::kUsed) continue;
            for (int corner = 0; corner < 4; ++corner)
                used[grid.Vertex(i + corner % 2, j + corner / 2)] = 1;
        }
    }
    return used;
}

// Is the ray whose stored fields these are within all rims that cut the ghost?
bool PassesRims(const GhostMesh& mesh, const float* fields) {
    for (int r = 0; r < static_cast<int>(mesh.rims.size()); ++r) {
        if (fields[mesh.rim_field(r)] > 0.0F) return false;
    }
    return true;
}

class MeshInFloats : public ::testing::TestWithParam<Case> {};

TEST_P(MeshInFloats, LiesOnTheMeshInDoubles) {
    const auto lens = testing::LibraryLens(GetParam().name);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    const std::size_t every = std::max<std::size_t>(1, sequences.size() / 30);
    std::vector<double> miss_px;
    std::size_t vertices = 0, fates_differ = 0;
    for (std::size_t n = 0; n < sequences.size(); n += every) {
        MeshSpec spec = SpecOf(*lens, sequences[n], GetParam().field_deg);
        const GhostMesh floats = BuildMesh(*lens, spec);
        spec.arithmetic = MeshArithmetic::kDouble;
        const GhostMesh doubles = BuildMesh(*lens, spec);
        EXPECT_TRUE(doubles.in_doubles);
        ASSERT_EQ(floats.grids.empty(), doubles.grids.empty());
        if (floats.grids.empty()) continue;
        const MeshGrid& a = floats.grids[0];
        const MeshGrid& b = doubles.grids[0];
        ASSERT_EQ(a.du, b.du);
        const std::vector<std::uint8_t> used = CornersOfUsedCells(b);
        for (std::size_t v = 0; v < a.alive.size(); ++v) {
            ++vertices;
            if (a.alive[v] != b.alive[v]) ++fates_differ;
            if (used[v] == 0 || a.alive[v] == 0) continue;
            for (std::size_t k = 0; k < a.nodes.size(); ++k) {
                const float* const fa =
                    &a.nodes[k].fields[v * static_cast<std::size_t>(floats.stored_count())];
                const float* const fb =
                    &b.nodes[k].fields[v * static_cast<std::size_t>(doubles.stored_count())];
                if (!PassesRims(doubles, fb)) continue;
                const Vec2d wanted = doubles.SensorPlace(fb, lens->sensor_gap_mm());
                if (wanted.length() > 30.0) continue;  // off the picture
                const Vec2d found = floats.SensorPlace(fa, lens->sensor_gap_mm());
                miss_px.push_back((found - wanted).length() / kPixel_mm);
            }
        }
    }
    ASSERT_GT(miss_px.size(), 150U);
    std::sort(miss_px.begin(), miss_px.end());
    const double p999 = miss_px[miss_px.size() * 999 / 1000];
    std::printf("%s: %zu places, p99.9 %.4f px, worst %.4f px, fates differ %zu of %zu\n",
                GetParam().name, miss_px.size(), p999, miss_px.back(), fates_differ, vertices);
    EXPECT_LT(p999, GetParam().allowed_px);
    EXPECT_LE(fates_differ, vertices / 2000);
}

INSTANTIATE_TEST_SUITE_P(Lenses, MeshInFloats,
                         ::testing::Values(Case{testing::kSeedName, 5.0, 0.02},
                                           Case{testing::kFisheyeName, 60.0, 0.05},
                                           Case{"canon-zoom-70-200mm-f2_8", 5.0, 0.05},
                                           Case{"schneider-anamorphic-31mm-f2", 2.0, 0.05},
                                           Case{"canon-rf-85mm-f1_2", 5.0, 0.1}));

void ExpectSameMesh(const GhostMesh& a, const GhostMesh& b) {
    ASSERT_EQ(a.grids.size(), b.grids.size());
    for (std::size_t g = 0; g < a.grids.size(); ++g) {
        EXPECT_TRUE(a.grids[g].alive == b.grids[g].alive);
        EXPECT_TRUE(a.grids[g].cells == b.grids[g].cells);
        for (std::size_t k = 0; k < a.grids[g].nodes.size(); ++k) {
            EXPECT_TRUE(a.grids[g].nodes[k].fields == b.grids[g].nodes[k].fields);
            EXPECT_TRUE(a.grids[g].nodes[k].passage == b.grids[g].nodes[k].passage);
        }
    }
}

TEST(MeshArithmetic, FallsBackToDoublesWhereFloatsAreNotGoodEnough) {
    const auto lens = testing::LibraryLens(testing::kSeedName);
    MeshSpec spec = SpecOf(*lens, {8, 2}, 7.0);
    const GhostMesh floats = BuildMesh(*lens, spec);
    EXPECT_FALSE(floats.in_doubles);
    // No float lies within a fiftieth of this; a few cells keep the patches it asks for few.
    spec.cells = 8;
    spec.position_tolerance_mm = 1e-6;
    const GhostMesh fallen_back = BuildMesh(*lens, spec);
    EXPECT_TRUE(fallen_back.in_doubles);
    spec.arithmetic = MeshArithmetic::kDouble;
    const GhostMesh doubles = BuildMesh(*lens, spec);
    ExpectSameMesh(fallen_back, doubles);
    EXPECT_GT(fallen_back.rays_traced, doubles.rays_traced) << "the attempt is counted";
}

TEST(MeshArithmetic, GivesTheSameMeshWhateverTheThreads) {
    const auto lens = testing::LibraryLens(testing::kSeedName);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    const auto build = [&](int thread_count) {
        std::vector<GhostMesh> meshes(sequences.size());
        ThreadPool threads(thread_count);
        threads.For(static_cast<int>(sequences.size()), [&](int i) {
            const auto n = static_cast<std::size_t>(i);
            meshes[n] = BuildMesh(*lens, SpecOf(*lens, sequences[n], 7.0));
        });
        return meshes;
    };
    const std::vector<GhostMesh> one = build(1), four = build(4);
    for (std::size_t n = 0; n < one.size(); ++n) ExpectSameMesh(one[n], four[n]);
}

TEST(MeshArithmetic, IsPartOfTheKey) {
    const auto lens = testing::LibraryLens(testing::kSeedName);
    const MeshSpec base = SpecOf(*lens, {8, 2}, 7.0);
    MeshSpec doubles = base;
    doubles.arithmetic = MeshArithmetic::kDouble;
    EXPECT_NE(MeshKey(*lens, base), MeshKey(*lens, doubles));
}

}  // namespace
}  // namespace flare
