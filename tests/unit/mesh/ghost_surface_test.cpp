// SPDX-License-Identifier: Apache-2.0
//
// A mesh is traced rays at its vertices and smooth in between: both are held against exact rays.
#include "core/mesh/ghost_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/optics/lens_state.h"
#include "core/spectrum/wavelength_plan.h"
#include "core/tracing/trace_reference.h"
#include "tests/support/lenses.h"
#include "tests/support/random.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

double Bernstein(int k, double t) {
    const double s = 1.0 - t;
    const double b[] = {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
    return b[k];
}

double ValueOf(const BezierNet& net, double a, double b) {
    double sum = 0.0;
    for (int j = 0; j < 4; ++j) {
        for (int i = 0; i < 4; ++i) {
            sum += net[static_cast<std::size_t>(4 * j + i)] * Bernstein(i, a) * Bernstein(j, b);
        }
    }
    return sum;
}

MeshSpec SpecOf(BounceSequence sequence, double field_deg) {
    MeshSpec spec;
    spec.sequence = std::move(sequence);
    spec.field_rad = RadiansFromDegrees(field_deg);
    spec.wavelengths_nm = {kLineD};
    return spec;
}

TEST(GhostSurface, LiesWithinTheToleranceOfExactRays) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    testing::Random random(31);
    for (const BounceSequence& sequence : {BounceSequence{10, 6}, {8, 4}, {2, 0}, {6, 2}, {9, 1}}) {
        const MeshSpec spec = SpecOf(sequence, 8.0);
        const auto mesh = std::make_shared<const GhostMesh>(BuildMesh(*lens, spec));
        const GhostSurface surface(mesh, lens->sensor_gap_mm());
        ASSERT_FALSE(surface.cells().empty());
        const LightBundle bundle(*lens, spec.field_rad, 0.0);
        const InteractionList list = WriteOut(*lens, sequence, kLineD);
        std::vector<double> errors, stop_errors;
        CellSurface cell_surface;
        for (int k = 0; k < 1500; ++k) {
            const CellPlace& cell = surface.cells()[static_cast<std::size_t>(
                random.Below(static_cast<int>(surface.cells().size())))];
            if (surface.UseOf(cell) != CellUse::kUsed) continue;
            const MeshGrid& grid = mesh->grids[static_cast<std::size_t>(cell.grid)];
            const double a = random.Uniform(0.0, 1.0), b = random.Uniform(0.0, 1.0);
            RayRecord record;
            const TraceResult exact = TraceRay(
                list, bundle.At(grid.u0 + (cell.i + a) * grid.du, grid.v0 + (cell.j + b) * grid.dv),
                {}, &record);
            // Only light that passes must be right.
            if (exact.fate != RayFate::kArrived) continue;
            surface.Evaluate(cell, {1.0}, 0, mesh->field_count(), cell_surface);
            errors.push_back(std::hypot(ValueOf(cell_surface.nets[0], a, b) - exact.sensor_mm.x,
                                        ValueOf(cell_surface.nets[1], a, b) - exact.sensor_mm.y));
            const auto stop = static_cast<std::size_t>(mesh->stop_field(0));
            stop_errors.push_back(
                std::hypot(ValueOf(cell_surface.nets[stop], a, b) - record.stop_mm[0].x,
                           ValueOf(cell_surface.nets[stop + 1], a, b) - record.stop_mm[0].y));
            // A ray that passes lies inside every rim that the mesh keeps.
            for (int rim = 0; rim < static_cast<int>(mesh->rims.size()); ++rim) {
                const auto f = static_cast<std::size_t>(mesh->rim_field(rim));
                EXPECT_LT(ValueOf(cell_surface.nets[f], a, b), 0.01);
            }
        }
        ASSERT_GT(errors.size(), 200U);
        std::sort(errors.begin(), errors.end());
        std::sort(stop_errors.begin(), stop_errors.end());
        EXPECT_LT(errors[errors.size() * 99 / 100], 2.0 * spec.position_tolerance_mm)
            << sequence[0];
        EXPECT_LT(errors[errors.size() / 2], 0.2 * spec.position_tolerance_mm) << sequence[0];
        EXPECT_LT(stop_errors[stop_errors.size() * 99 / 100], 2.0 * 8.55 * spec.mask_tolerance);
    }
}

// What a sweep of settings asks for: one grid, and straight lines between its vertices.
TEST(GhostSurface, WithoutPatchesAndSlopesIsThePlainGrid) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    MeshSpec spec = SpecOf({9, 1}, 8.0);
    spec.cells = 12;
    EXPECT_GT(BuildMesh(*lens, spec).grids.size(), 1U);
    spec.patch_cells = 0;
    const auto mesh = std::make_shared<const GhostMesh>(BuildMesh(*lens, spec));
    ASSERT_EQ(mesh->grids.size(), 1U);
    const GhostSurface straight(mesh, lens->sensor_gap_mm(), 1e300, false);
    const GhostSurface smooth(mesh, lens->sensor_gap_mm());
    ASSERT_FALSE(straight.cells().empty());
    const MeshGrid& grid = mesh->grids.front();
    const auto corner_x = [&](int i, int j) {
        const std::size_t at = grid.Vertex(i, j) * static_cast<std::size_t>(mesh->stored_count());
        return mesh->SensorPlace(&grid.nodes[0].fields[at], lens->sensor_gap_mm()).x;
    };
    CellSurface flat, curved;
    double bend = 0.0;
    for (const CellPlace& cell : straight.cells()) {
        const int i = cell.i, j = cell.j;
        const double expected = 0.7 * (0.4 * corner_x(i, j) + 0.6 * corner_x(i, j + 1)) +
                                0.3 * (0.4 * corner_x(i + 1, j) + 0.6 * corner_x(i + 1, j + 1));
        straight.Evaluate(cell, {1.0}, 0, mesh->field_count(), flat);
        smooth.Evaluate(cell, {1.0}, 0, mesh->field_count(), curved);
        EXPECT_NEAR(ValueOf(flat.nets[0], 0.3, 0.6), expected, 1e-5);
        bend = std::max(bend, std::abs(ValueOf(curved.nets[0], 0.3, 0.6) - expected));
    }
    EXPECT_GT(bend, 1e-3);
}

TEST(GhostSurface, InterpolatesBetweenTracedWavelengths) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    MeshSpec spec = SpecOf({10, 8}, 5.0);
    spec.wavelengths_nm = ChebyshevNodes(390.0, 730.0, 3);
    const auto mesh = std::make_shared<const GhostMesh>(BuildMesh(*lens, spec));
    const GhostSurface surface(mesh, lens->sensor_gap_mm());
    const LightBundle bundle(*lens, spec.field_rad, 0.0);
    const InteractionList list = WriteOut(*lens, spec.sequence, 470.0);
    const std::vector<double> weights = NodeWeights(spec.wavelengths_nm, 470.0);
    CellSurface out;
    int compared = 0;
    for (const CellPlace& cell : surface.cells()) {
        if (surface.UseOf(cell) != CellUse::kUsed) continue;
        const MeshGrid& grid = mesh->grids[static_cast<std::size_t>(cell.grid)];
        const TraceResult exact = TraceRay(
            list, bundle.At(grid.u0 + (cell.i + 0.5) * grid.du, grid.v0 + (cell.j + 0.5) * grid.dv),
            {}, nullptr);
        if (exact.fate != RayFate::kArrived) continue;
        surface.Evaluate(cell, weights, 0, 2, out);
        EXPECT_NEAR(ValueOf(out.nets[0], 0.5, 0.5), exact.sensor_mm.x, 0.01);
        EXPECT_NEAR(ValueOf(out.nets[1], 0.5, 0.5), exact.sensor_mm.y, 0.01);
        ++compared;
    }
    EXPECT_GT(compared, 100);
}

// One mesh, the sensor wherever the focus puts it.
TEST(GhostSurface, FollowsTheSensorThatIsFocused) {
    const auto base = testing::BuildLens(testing::SeedLens());
    MeshSpec spec = SpecOf({10, 6}, 8.0);
    spec.arithmetic = MeshArithmetic::kDouble;  // corners are compared with the reference
    const auto mesh = std::make_shared<const GhostMesh>(BuildMesh(*base, spec));
    for (const double focus_m : {1.0, 0.4}) {
        const LensInState near = *SetState(base, {focus_m, {}});
        EXPECT_GT(near.lens->sensor_gap_mm(), base->sensor_gap_mm() + 2.0);
        EXPECT_EQ(MeshKey(*near.lens, spec), MeshKey(*base, spec));
        const GhostSurface surface(mesh, near.lens->sensor_gap_mm());
        const LightBundle bundle(*near.lens, spec.field_rad, 0.0);
        const InteractionList list = WriteOut(*near.lens, spec.sequence, kLineD);
        CellSurface out;
        int compared = 0;
        for (const CellPlace& cell : surface.cells()) {
            if (surface.UseOf(cell) != CellUse::kUsed) continue;
            const MeshGrid& grid = mesh->grids[static_cast<std::size_t>(cell.grid)];
            surface.Evaluate(cell, {1.0}, 0, 2, out);
            const TraceResult corner =
                TraceRay(list, bundle.At(grid.u0 + cell.i * grid.du, grid.v0 + cell.j * grid.dv),
                         {}, nullptr);
            if (corner.fate == RayFate::kArrived) {
                EXPECT_NEAR(out.nets[0][0], corner.sensor_mm.x, 1e-5);
                EXPECT_NEAR(out.nets[1][0], corner.sensor_mm.y, 1e-5);
            }
            const TraceResult middle = TraceRay(
                list,
                bundle.At(grid.u0 + (cell.i + 0.5) * grid.du, grid.v0 + (cell.j + 0.5) * grid.dv),
                {}, nullptr);
            if (middle.fate != RayFate::kArrived) continue;
            EXPECT_NEAR(ValueOf(out.nets[0], 0.5, 0.5), middle.sensor_mm.x, 0.01);
            EXPECT_NEAR(ValueOf(out.nets[1], 0.5, 0.5), middle.sensor_mm.y, 0.01);
            ++compared;
        }
        EXPECT_GT(compared, 200);
    }
}

TEST(MeshKey, NamesTheSensorOnlyWhereTheLightIsReflectedThere) {
    Prescription prescription = testing::SeedLens();
    SurfacePrescription sensor;
    sensor.kind = SurfaceKind::kSensor;
    sensor.reflectance = 0.05;
    sensor.semi_diameter_mm = 21.6;
    prescription.surfaces.push_back(sensor);
    const auto base = testing::BuildLens(prescription);
    const auto near = SetState(base, {1.0, {}})->lens;
    const auto plain = testing::BuildLens(testing::SeedLens());
    prescription.surfaces.back().semi_diameter_mm = 18.0;
    const auto smaller = testing::BuildLens(prescription);
    prescription.surfaces.back().reflectance = 0.1;
    const auto brighter = testing::BuildLens(prescription);
    const MeshSpec inside = SpecOf({8, 2}, 7.0), mirrored = SpecOf({11, 2}, 7.0);
    EXPECT_EQ(MeshKey(*near, inside), MeshKey(*base, inside));
    EXPECT_EQ(MeshKey(*plain, inside), MeshKey(*base, inside));
    EXPECT_EQ(MeshKey(*smaller, inside), MeshKey(*base, inside));
    EXPECT_NE(MeshKey(*near, mirrored), MeshKey(*base, mirrored));
    EXPECT_NE(MeshKey(*smaller, mirrored), MeshKey(*base, mirrored));
    EXPECT_EQ(MeshKey(*brighter, mirrored), MeshKey(*smaller, mirrored));
    // And rightly so: the mirrored ghost is another one there.
    const GhostMesh a = BuildMesh(*base, mirrored), b = BuildMesh(*near, mirrored);
    ASSERT_FALSE(a.grids.empty());
    EXPECT_FALSE(a.grids[0].nodes[0].fields == b.grids[0].nodes[0].fields);
}

TEST(Mesh, IsMirrorSymmetricAboutTheMeridionalPlane) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    const GhostMesh mesh = BuildMesh(*lens, SpecOf({10, 4}, 10.0));
    ASSERT_FALSE(mesh.grids.empty());
    const MeshGrid& grid = mesh.grids[0];
    EXPECT_NEAR(grid.v0 + 0.5 * (grid.nv - 1) * grid.dv, 0.0, 1e-12);
    const auto fields = static_cast<std::size_t>(mesh.stored_count());
    for (int j = 0; j < grid.nv; ++j) {
        for (int i = 0; i < grid.nu; ++i) {
            const std::size_t a = grid.Vertex(i, j), b = grid.Vertex(i, grid.nv - 1 - j);
            ASSERT_EQ(grid.alive[a], grid.alive[b]);
            if (grid.alive[a] == 0) continue;
            EXPECT_EQ(grid.nodes[0].fields[a * fields], grid.nodes[0].fields[b * fields]);
            EXPECT_EQ(grid.nodes[0].fields[a * fields + 1], -grid.nodes[0].fields[b * fields + 1]);
        }
    }
}

TEST(Mesh, DependsOnItsSpecAloneAndCountsItsBytes) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    const MeshSpec spec = SpecOf({8, 2}, 7.0);
    const GhostMesh a = BuildMesh(*lens, spec), b = BuildMesh(*lens->WithBareGlass(), spec);
    ASSERT_EQ(a.grids.size(), b.grids.size());
    for (std::size_t g = 0; g < a.grids.size(); ++g) {
        EXPECT_TRUE(a.grids[g].nodes[0].fields == b.grids[g].nodes[0].fields);
        EXPECT_TRUE(a.grids[g].nodes[0].passage == b.grids[g].nodes[0].passage);
    }
    EXPECT_GT(a.rays_traced, 500U);
    std::size_t floats = 0;
    for (const MeshGrid& grid : a.grids)
        floats += grid.nodes[0].fields.size() + grid.nodes[0].passage.size();
    EXPECT_GE(a.bytes(), floats * sizeof(float));
    EXPECT_LT(a.bytes(), 4 * floats * sizeof(float) + 100'000);
}

TEST(MeshKey, NamesEverythingThatChangesTheMesh) {
    const auto lens = testing::BuildLens(testing::SeedLens());
    const MeshSpec base = SpecOf({8, 2}, 7.0);
    const Fingerprint key = MeshKey(*lens, base);
    EXPECT_EQ(MeshKey(*lens, base), key);
    EXPECT_EQ(MeshKey(*lens->WithBareGlass(), base), key) << "coatings do not bend rays";
    std::vector<Fingerprint> keys{key};
    const auto add = [&](auto change) {
        MeshSpec spec = base;
        change(spec);
        keys.push_back(MeshKey(*lens, spec));
    };
    add([](MeshSpec& s) { s.sequence = {8, 1}; });
    add([](MeshSpec& s) { s.field_rad += 1e-12; });
    add([](MeshSpec& s) { s.inverse_distance = 1e-6; });
    add([](MeshSpec& s) { s.wavelengths_nm = {550.0}; });
    add([](MeshSpec& s) { s.wavelengths_nm.push_back(550.0); });
    add([](MeshSpec& s) { s.cells *= 2; });
    add([](MeshSpec& s) { s.patch_cells *= 2; });
    add([](MeshSpec& s) { s.position_tolerance_mm *= 2.0; });
    add([](MeshSpec& s) { s.mask_tolerance *= 2.0; });
    add([](MeshSpec& s) { s.cosine_tolerance *= 2.0; });
    Prescription other = testing::SeedLens();
    other.surfaces[0].radius_mm *= 1.0 + 1e-9;
    keys.push_back(MeshKey(*testing::BuildLens(other), base));
    std::sort(keys.begin(), keys.end());
    EXPECT_EQ(std::unique(keys.begin(), keys.end()), keys.end());
}

}  // namespace
}  // namespace flare
