// SPDX-License-Identifier: Apache-2.0
//
// Light that glass takes away: the way through it, from the mesh and of exact rays, and pictures in
// the violet, where dense flint absorbs half in 10 mm.
#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/mesh_builder.h"
#include "core/mesh/transmission.h"
#include "core/optics/paraxial.h"
#include "core/render/ghost_choice.h"
#include "tests/support/brute_force.h"
#include "tests/support/lenses.h"
#include "tests/support/rendering.h"
#include "tests/support/seed_lens.h"

namespace flare {
namespace {

using testing::LightAt;
using testing::Studio;

constexpr double kThickness_mm = 10.0;
// k = 2.1833e-6 at 400 nm in Schott's data sheet of N-SF66: alpha = 4 pi k / lambda.
constexpr double kAlpha = 4.0 * kPi * 2.1833e-6 / 400e-6;

Prescription Flint() {
    Prescription lens = testing::PlanoConvex();
    lens.surfaces[1].nd.reset();
    lens.surfaces[1].glass = "SCHOTT N-SF66";
    lens.surfaces[1].radius_mm = 90.0;
    lens.surfaces[1].gap_mm = kThickness_mm;
    return lens;
}

// The seed lens with two of its glasses from the catalogue.
Prescription MixedSeed() {
    Prescription lens = testing::SeedLens();
    for (const std::size_t i : {std::size_t{0}, std::size_t{7}}) {
        lens.surfaces[i].nd.reset();
        lens.surfaces[i].vd.reset();
        lens.surfaces[i].glass = i == 0 ? "SCHOTT N-SF66" : "SCHOTT SF57";
    }
    return lens;
}

TEST(Absorption, OnTheAxisIsThatOfTheThickness) {
    const auto lens = testing::BuildLens(Flint());
    const double n = lens->surfaces()[1].behind.Index(400.0);
    const double r = (n - 1.0) * (n - 1.0) / ((n + 1.0) * (n + 1.0));
    EXPECT_NEAR(AxialTransmittance(*lens, 400.0),
                (1.0 - r) * (1.0 - r) * std::exp(-kAlpha * kThickness_mm), 1e-6);
}

TEST(Absorption, AlongAGhostsPathIsThatOfExactRays) {
    ThreadPool threads(2);
    const std::vector<double> wavelengths{400.0, kLineD};
    for (const auto& [prescription, sequences] :
         {std::pair(Flint(), std::vector<BounceSequence>{{2, 1}}),
          std::pair(MixedSeed(), std::vector<BounceSequence>{{10, 6}, {1, 0}, {8, 4}, {9, 1}})}) {
        const auto lens = testing::BuildLens(prescription);
        const TransmissionTables tables(*lens, wavelengths, threads);
        for (const BounceSequence& sequence : sequences) {
            MeshSpec spec;
            spec.sequence = sequence;
            spec.field_rad = RadiansFromDegrees(6.0);
            spec.wavelengths_nm = wavelengths;
            spec.arithmetic = MeshArithmetic::kDouble;  // vertices are compared with exact rays
            const GhostMesh mesh = BuildMesh(*lens, spec);
            ASSERT_FALSE(mesh.grids.empty());
            EXPECT_FALSE(mesh.absorbing.empty());
            const auto path = tables.PathOf(*lens, sequence);
            const LightBundle bundle(*lens, spec.field_rad, 0.0);
            const auto count = static_cast<std::size_t>(mesh.passage_count());
            int compared = 0;
            double least = 1.0;
            for (const MeshGrid& grid : mesh.grids) {
                for (std::size_t k = 0; k < 2; ++k) {
                    const InteractionList list = WriteOut(*lens, sequence, wavelengths[k]);
                    for (int j = 0; j < grid.nv; j += 3) {
                        for (int i = 0; i < grid.nu; i += 3) {
                            RayRecord record;
                            const TraceResult ray = TraceRay(
                                list, bundle.At(grid.u0 + i * grid.du, grid.v0 + j * grid.dv), {},
                                &record);
                            if (ray.fate != RayFate::kArrived) continue;
                            const float* const from =
                                &grid.nodes[k].passage[grid.Vertex(i, j) * count];
                            const std::vector<double> passage(from, from + count);
                            const double exact = PathWeight(*lens, list, record);
                            EXPECT_NEAR(path.Weight(static_cast<int>(k), passage), exact,
                                        1e-5 * exact);
                            double lost = 0.0;
                            for (std::size_t s = 0; s < record.segment_mm.size(); ++s) {
                                lost += list.steps[s].absorption_per_mm * record.segment_mm[s];
                            }
                            least = std::min(least, std::exp(-lost));
                            ++compared;
                        }
                    }
                }
            }
            EXPECT_GT(compared, 50);
            EXPECT_LT(least, 0.7) << "the test is about glass that absorbs";
        }
    }
}

// Through a small stop the ghost of the two faces goes 3 x 10 mm through glass.
TEST(Absorption, DarkensAPicturesGhostByItsWayThroughTheGlass) {
    Studio studio;
    const auto lens = testing::BuildLens(Flint());
    FlareRequest request = testing::SpectralRequest(lens, 60.0, 80, 80);
    request.image.sensor_width_mm = 40.0;
    request.wavelengths_nm = {400.0, 550.0, kLineD};
    request.lights = {LightAt(0.5)};
    const FlareImage image = studio.Shoot(request).image;
    const double opening = StopForFNumber(*lens, 60.0).semi_diameter_mm;
    const double area = kPi * opening * opening;
    for (const ImagePlane& plane : image.planes) {
        if (plane.name != "S0.400nm" && plane.name != "S0.550nm") continue;
        const double nm = plane.name == "S0.400nm" ? 400.0 : 550.0;
        const Glass& glass = lens->surfaces()[1].behind;
        const double n = glass.Index(nm);
        const double r = (n - 1.0) * (n - 1.0) / ((n + 1.0) * (n + 1.0));
        const double alpha = nm == 400.0 ? kAlpha : glass.AbsorptionPerMm(nm);
        const double expected =
            area * r * r * (1.0 - r) * (1.0 - r) * std::exp(-alpha * 3.0 * kThickness_mm);
        EXPECT_NEAR(testing::Sum(plane) * 0.25, expected, 4e-3 * expected) << nm;
    }
    // In the violet an eighth is left.
    EXPECT_NEAR(std::exp(-kAlpha * 3.0 * kThickness_mm), 0.128, 1e-3);
}

// Two glasses of one dispersion, of which the catalogue knows the absorption of one: a mesh keeps
// the ways through that one only, so neither lens may be given the other's.
TEST(Absorption, TellsMeshesApart) {
    Prescription known = Flint(), unknown = Flint();
    known.surfaces[1].glass = "HIKARI J-SF03";
    unknown.surfaces[1].glass = "HIKARI J-SF03HS";
    const auto a = testing::BuildLens(known), b = testing::BuildLens(unknown);
    for (const double nm : {400.0, kLineD, 700.0}) {
        ASSERT_EQ(a->surfaces()[1].behind.Index(nm), b->surfaces()[1].behind.Index(nm));
    }
    MeshSpec spec;
    spec.sequence = {2, 1};
    spec.wavelengths_nm = {kLineD};
    ASSERT_NE(BuildMesh(*a, spec).passage_count(), BuildMesh(*b, spec).passage_count());
    EXPECT_NE(MeshKey(*a, spec), MeshKey(*b, spec));
}

}  // namespace
}  // namespace flare
