// SPDX-License-Identifier: Apache-2.0
//
// What a path lets through, many rays at once by polynomials, against the path asked ray by ray.
#include "core/mesh/passage_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/spectrum/wavelength_plan.h"
#include "tests/support/lenses.h"

namespace flare {
namespace {

struct Case {
    const char* name;
    double field_deg;
};

class PassageInColumns : public ::testing::TestWithParam<Case> {};

// At every living vertex of every ghost, those next to the critical angle included.
TEST_P(PassageInColumns, WeighsAsThePathDoes) {
    const auto lens = testing::LibraryLens(GetParam().name);
    ThreadPool threads(2);
    const TransmissionTables tables(*lens, EvenInWavelength(380.0, 780.0, 5), threads);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
    const std::size_t every = std::max<std::size_t>(1, sequences.size() / 25);
    std::size_t compared = 0, asked = 0, all = 0;
    double worst = 0.0;
    for (std::size_t n = 0; n < sequences.size(); n += every) {
        MeshSpec spec;
        spec.sequence = sequences[n];
        spec.field_rad = RadiansFromDegrees(GetParam().field_deg);
        spec.wavelengths_nm = ChebyshevNodes(405.0, 705.0, 3);
        spec.cells = 16;
        spec.position_tolerance_mm = 0.03;
        const GhostMesh mesh = BuildMesh(*lens, spec);
        if (mesh.grids.empty()) continue;
        const MeshGrid& grid = mesh.grids[0];
        const auto passages = static_cast<std::size_t>(mesh.passage_count());
        std::vector<std::vector<double>> weights;
        for (const double w : tables.wavelengths_nm())
            weights.push_back(NodeWeights(spec.wavelengths_nm, w));
        PassageRange range(passages);
        std::vector<std::size_t> living;
        for (std::size_t v = 0; v < grid.alive.size(); ++v) {
            if (grid.alive[v] == 0) continue;
            living.push_back(v);
            std::vector<const float*> nodes;
            for (const MeshNode& node : grid.nodes) nodes.push_back(&node.passage[v * passages]);
            range.Add(nodes);
        }
        if (living.empty()) continue;
        PassageColumns columns;
        columns.Resize(3, passages, living.size());
        for (std::size_t k = 0; k < living.size(); ++k) {
            for (std::size_t node = 0; node < 3; ++node) {
                for (std::size_t s = 0; s < passages; ++s) {
                    columns.values[(node * passages + s) * columns.stride + k] =
                        grid.nodes[node].passage[living[k] * passages + s];
                }
            }
        }
        const TransmissionTables::Path path = tables.PathOf(*lens, spec.sequence);
        const PathInColumns in_columns(path, weights, range);
        asked += in_columns.asked();
        all += path.steps() * weights.size();
        std::vector<float> found;
        for (std::size_t band = 0; band < weights.size(); ++band) {
            in_columns.Weights(band, columns, found);
            std::vector<double> wanted;
            for (const std::size_t v : living) {
                std::vector<double> passage(passages, 0.0);
                for (std::size_t node = 0; node < 3; ++node) {
                    for (std::size_t s = 0; s < passages; ++s) {
                        passage[s] +=
                            weights[band][node] *
                            static_cast<double>(grid.nodes[node].passage[v * passages + s]);
                    }
                }
                wanted.push_back(path.Weight(static_cast<int>(band), passage));
            }
            const double largest = *std::max_element(wanted.begin(), wanted.end());
            for (std::size_t k = 0; k < wanted.size(); ++k) {
                const double miss = std::abs(static_cast<double>(found[k]) - wanted[k]) / largest;
                worst = std::max(worst, miss);
                ++compared;
            }
        }
    }
    std::printf("%s: %zu compared, worst %.1e of the ghost's brightest, %zu of %zu asked\n",
                GetParam().name, compared, worst, asked, all);
    EXPECT_GT(compared, 3000U);
    EXPECT_LT(worst, 2e-4);
    EXPECT_LT(asked, all / 2);
}

INSTANTIATE_TEST_SUITE_P(Lenses, PassageInColumns,
                         ::testing::Values(Case{testing::kSeedName, 5.0},
                                           Case{testing::kPrimeName, 5.0},
                                           Case{testing::kFisheyeName, 60.0},
                                           Case{"canon-zoom-70-200mm-f2_8", 5.0}));

}  // namespace
}  // namespace flare
