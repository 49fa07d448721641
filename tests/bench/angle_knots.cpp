// SPDX-License-Identifier: Apache-2.0
//
// What meshes at knots of field angle would give: the main grids of all two-reflection ghosts of a
// preview, traced at four angles `spacing` apart over one rectangle of the pupil and interpolated
// cubically to the angle in the middle, against exact rays there in doubles; and what tracing
// afresh costs.
//
//   angle_knots LENS_FILE FIELD_DEG ...
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/mesh/raw_grid.h"
#include "core/render/light_meshes.h"
#include "core/render/quality.h"
#include "core/spectrum/wavelength_plan.h"
#include "server/lens_library.h"

namespace flare {
namespace {

constexpr double kPixel_mm = 36.0 / 1920.0;
constexpr double kOnPicture_mm = 30.0;  // from the axis
constexpr std::size_t kKnots = 4;
// Of a cubic in the middle of four values.
constexpr std::array<float, kKnots> kWeights = {-0.0625F, 0.5625F, 0.5625F, -0.0625F};

double Now_ms() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

struct Tally {
    std::size_t without_knots = 0;      // ghosts that do not pass at every knot
    std::size_t passing = 0, dead = 0;  // vertices; those that have died at some knot
    double search_ms = 0.0, grids_ms = 0.0, interpolation_ms = 0.0, meshes_ms = 0.0;
    std::size_t knot_bytes = 0, mesh_bytes = 0;
    std::uint64_t mesh_rays = 0;
    std::vector<double> miss_px;
};

MeshSpec SpecOf(const BounceSequence& sequence, double field_deg) {
    const QualitySettings settings = SettingsOf(QualityPreset::kPreview);
    MeshSpec spec;
    spec.sequence = sequence;
    spec.field_rad = RadiansFromDegrees(field_deg);
    SetQuality(settings, spec);
    return spec;
}

struct Knot {
    MeshSpec spec;
    std::unique_ptr<GridTracer> tracer;
    RawGrid grid;
};

// All columns that a mesh keeps, node by node.
std::vector<TraceColumns> Interpolated(const std::array<Knot, kKnots>& knots, Tally& tally) {
    const double before = Now_ms();
    const TracedRays& first = *knots.front().grid.rays;
    const std::size_t rays = first.state.size();
    std::vector<TraceColumns> out(first.nodes.size());
    const auto add = [&](std::size_t n, std::vector<float> TraceColumns::*column) {
        const std::size_t stride = first.nodes[n].stride;
        const std::size_t rows = (first.nodes[n].*column).size() / stride;
        std::vector<float>& to = out[n].*column;
        to.resize(rows * rays);
        for (std::size_t row = 0; row < rows; ++row) {
            std::array<const float*, kKnots> from{};
            for (std::size_t k = 0; k < kKnots; ++k)
                from[k] = &(knots[k].grid.rays->nodes[n].*column)[row * stride];
            float* const at = &to[row * rays];
            for (std::size_t r = 0; r < rays; ++r) {
                at[r] = kWeights[0] * from[0][r] + kWeights[1] * from[1][r] +
                        kWeights[2] * from[2][r] + kWeights[3] * from[3][r];
            }
        }
        tally.knot_bytes += rows * rays * sizeof(float);
    };
    for (std::size_t n = 0; n < out.size(); ++n) {
        for (const auto column :
             {&TraceColumns::exit_x, &TraceColumns::exit_y, &TraceColumns::slope_x,
              &TraceColumns::slope_y, &TraceColumns::stop_x, &TraceColumns::stop_y,
              &TraceColumns::rim_ratio2, &TraceColumns::rare_cos2}) {
            add(n, column);
        }
    }
    tally.interpolation_ms += Now_ms() - before;
    return out;
}

// Every vertex that passes at the middle angle, at the middle wavelength.
void Compare(const Lens& lens, const GridTracer& exact, const std::array<Knot, kKnots>& knots,
             const std::vector<TraceColumns>& found, Tally& tally) {
    const double gap_mm = lens.nominal_sensor_gap_mm();
    const RawGrid& raw = knots.front().grid;
    const InteractionList& list = exact.lists()[exact.lists().size() / 2];
    const TraceColumns& node = found[found.size() / 2];
    for (int j = raw.mirror_row; j < raw.grid.nv; ++j) {
        for (int i = 0; i < raw.grid.nu; ++i) {
            const Ray ray =
                exact.bundle().At(raw.grid.u0 + i * raw.grid.du, raw.grid.v0 + j * raw.grid.dv);
            const TraceResult truth = TraceRay(list, ray, {}, nullptr);
            if (truth.fate != RayFate::kArrived) continue;
            ++tally.passing;
            const std::size_t r = raw.Ray(i, j);
            const bool alive = std::all_of(knots.begin(), knots.end(), [&](const Knot& knot) {
                return knot.grid.rays->state[r] == VertexState::kAlive;
            });
            if (!alive) {
                ++tally.dead;
                continue;
            }
            const Vec3d& d = truth.exit_direction;
            const Vec2d place = truth.sensor_mm + Vec2d(d.x / d.z, d.y / d.z) * gap_mm;
            if (place.length() > kOnPicture_mm) continue;
            const auto on_sensor = [&](float at, float slope) {
                return static_cast<double>(at) + gap_mm * static_cast<double>(slope);
            };
            const Vec2d guess(on_sensor(node.exit_x[r], node.slope_x[r]),
                              on_sensor(node.exit_y[r], node.slope_y[r]));
            tally.miss_px.push_back((guess - place).length() / kPixel_mm);
        }
    }
}

void Ghost(const Lens& lens, const BounceSequence& sequence, double field_deg, double spacing_deg,
           Tally& tally) {
    const MeshSpec spec = SpecOf(sequence, field_deg);
    GridTracer exact(lens, spec, MeshArithmetic::kFloat);
    double before = Now_ms();
    const std::optional<Rect> here = FindPassRegion(exact.lists(), exact.bundle()).rect;
    tally.search_ms += Now_ms() - before;
    if (here) {
        before = Now_ms();
        exact.MainGrid(*here, spec.cells);
        tally.grids_ms += Now_ms() - before;
    }
    before = Now_ms();
    const GhostMesh mesh = BuildMesh(lens, spec);
    tally.meshes_ms += Now_ms() - before;
    tally.mesh_bytes += mesh.bytes();
    tally.mesh_rays += mesh.rays_traced;

    std::array<Knot, kKnots> knots;
    Rect all{1e300, -1e300, 1e300, -1e300};
    for (std::size_t k = 0; k < kKnots; ++k) {
        const double offset = static_cast<double>(k) - 0.5 * (kKnots - 1);
        knots[k].spec = SpecOf(sequence, field_deg + offset * spacing_deg);
        knots[k].tracer = std::make_unique<GridTracer>(lens, knots[k].spec, MeshArithmetic::kFloat);
        const GridTracer& tracer = *knots[k].tracer;
        const std::optional<Rect> rect = FindPassRegion(tracer.lists(), tracer.bundle()).rect;
        if (!rect) {
            tally.without_knots += here ? 1 : 0;
            return;
        }
        all = {std::min(all.u0, rect->u0), std::max(all.u1, rect->u1), std::min(all.v0, rect->v0),
               std::max(all.v1, rect->v1)};
    }
    for (Knot& knot : knots) knot.grid = knot.tracer->MainGrid(all, knot.spec.cells);
    Compare(lens, exact, knots, Interpolated(knots, tally), tally);
}

void Report(const Lens& lens, double field_deg, double spacing_deg) {
    Tally tally;
    for (const BounceSequence& sequence : TwoReflectionSequences(lens))
        Ghost(lens, sequence, field_deg, spacing_deg, tally);
    std::vector<double>& miss = tally.miss_px;
    std::sort(miss.begin(), miss.end());
    const auto at = [&](double share) {
        return miss.empty()
                   ? 0.0
                   : miss[static_cast<std::size_t>(share * static_cast<double>(miss.size() - 1))];
    };
    std::printf(
        "%5.1f %4.2f | %7.4f %7.4f %7.3f %7.2f | %5.2f %% %3zu | %6.1f %6.1f %6.1f | %5.1f "
        "%5.1f %7llu | %5.1f\n",
        field_deg, spacing_deg, at(0.5), at(0.99), at(0.999), at(1.0),
        100.0 * static_cast<double>(tally.dead) /
            static_cast<double>(std::max<std::size_t>(1, tally.passing)),
        tally.without_knots, tally.search_ms, tally.grids_ms, tally.interpolation_ms,
        tally.meshes_ms, static_cast<double>(tally.mesh_bytes) / 1e6,
        static_cast<unsigned long long>(tally.mesh_rays),
        static_cast<double>(tally.knot_bytes) / 1e6);
}

int Main(int argc, char** argv) {
    if (argc < 3) {
        std::fprintf(stderr, "usage: angle_knots LENS_FILE FIELD_DEG ...\n");
        return 2;
    }
    const auto lens = LoadLensFile(argv[1]);
    if (!lens) {
        std::fprintf(stderr, "%s\n", lens.error().message.c_str());
        return 2;
    }
    std::printf(
        "field step | px off: p50   p99    p99.9   worst |  dead  none | ms: search grids "
        "interpolation | exact ms, MB, rays | MB a knot\n");
    for (int k = 2; k < argc; ++k) {
        for (const double spacing_deg : {0.25, 0.5, 1.0, 2.0})
            Report(**lens, std::atof(argv[k]), spacing_deg);
    }
    return 0;
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    return flare::Main(argc, argv);
}
