// SPDX-License-Identifier: Apache-2.0
//
// How far the tracer in floats lies from the reference in doubles: for every lens of the library
// (or those named) and every ghost of two reflections, random rays over the ghost's own pass
// region, no rim ending any. Prints a table for docs/accuracy.md.
//
//   float_accuracy [--rays N] [--field-deg A] [LENS ...]
//   float_accuracy --map [--rays N] [LENS ...]
//
// The second form prints a map as CSV, one line for each lens, field angle (0 to 20 degrees) and
// ghost: its own p99.9 and what it is traced in.
//
// Pixels are those of a frame 36 mm wide and 1920 wide; p99.9 is over the rays that pass every rim
// and land within 40 mm of the axis. A ghost whose own p99.9 is above the limit of its lens (0.02
// px up to 200 mm of focal length, else 0.05) ought to be traced in doubles; `left` counts those
// that the mesh builder traces in floats all the same, for a preview and for a final.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "core/base/parallel.h"
#include "core/base/units.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/light_meshes.h"
#include "core/render/quality.h"
#include "core/spectrum/wavelength_plan.h"
#include "server/lens_library.h"
#include "tests/support/float_comparison.h"

namespace flare {
namespace {

struct Options {
    std::size_t rays = 100'000;
    double field_deg = 5.0;
    bool map = false;
    std::vector<std::string> lenses;
};

struct Ghost {
    BounceSequence sequence;
    testing::FloatComparison rays;
    double p999_px = 0.0;
    bool in_doubles[2] = {false, false};  // for a preview, for a final
};

bool TracedInDoubles(const Lens& lens, const LightBundle& bundle, const BounceSequence& sequence,
                     double azimuth_rad, QualityPreset preset) {
    const QualitySettings settings = SettingsOf(preset);
    MeshSpec spec;
    spec.sequence = sequence;
    spec.field_rad = bundle.field_rad();
    spec.azimuth_rad = azimuth_rad;
    SetQuality(settings, spec);
    return BuildMesh(lens, spec).in_doubles;
}

void PrintRow(const Lens& lens, std::vector<Ghost>& ghosts, double limit_px) {
    testing::FloatComparison all;
    std::vector<float> floats[2];
    int above = 0, doubles[2] = {0, 0}, left[2] = {0, 0}, lit = 0;
    double worst_px = 0.0;
    for (Ghost& ghost : ghosts) {
        if (ghost.rays.rays == 0) continue;
        ++lit;
        all.Add(ghost.rays);
        worst_px = std::max(worst_px, ghost.p999_px);
        above += ghost.p999_px > limit_px ? 1 : 0;
        for (int q = 0; q < 2; ++q) {
            doubles[q] += ghost.in_doubles[q] ? 1 : 0;
            left[q] += ghost.p999_px > limit_px && !ghost.in_doubles[q] ? 1 : 0;
            if (ghost.in_doubles[q]) continue;
            floats[q].insert(floats[q].end(), ghost.rays.miss_px.begin(), ghost.rays.miss_px.end());
        }
    }
    std::printf(
        "| %s | %.0f | %d | %.5f | %.5f | %.5f | %.4f | %d | %d, %d | %d, %d | %.4f, %.4f "
        "| %.1e | %.1e | %.1e |\n",
        lens.name().c_str(), lens.first_order().efl_mm, lit, testing::Percentile(all.miss_px, 0.5),
        testing::Percentile(all.miss_px, 0.999), testing::Percentile(all.unclipped_px, 0.999),
        worst_px, above, doubles[0], doubles[1], left[0], left[1],
        testing::Percentile(floats[0], 0.999), testing::Percentile(floats[1], 0.999),
        static_cast<double>(all.fates_differ) / static_cast<double>(all.rays),
        all.farthest_from_edge,
        static_cast<double>(all.ends_differ) / static_cast<double>(all.rays));
    std::fflush(stdout);
}

double LimitFor(const Lens& lens) {
    return lens.first_order().efl_mm > 200.0 ? 0.05 : 0.02;
}

// Of every ghost of two reflections.
std::vector<Ghost> MeasureGhosts(const Lens& lens, double field_deg, std::size_t rays,
                                 ThreadPool& threads) {
    const double azimuth_rad = lens.rotational() ? 0.0 : 0.5;
    const LightBundle bundle(lens, RadiansFromDegrees(field_deg), 0.0, azimuth_rad);
    const testing::FloatTracerComparison comparison(lens, bundle);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(lens);
    std::vector<Ghost> ghosts(sequences.size());
    threads.For(static_cast<int>(sequences.size()), [&](int i) {
        const auto n = static_cast<std::size_t>(i);
        Ghost& ghost = ghosts[n];
        ghost.sequence = sequences[n];
        ghost.rays = comparison.Compare(sequences[n], rays, n + 1);
        ghost.p999_px = testing::Percentile(ghost.rays.miss_px, 0.999);
        if (ghost.rays.rays == 0) return;
        ghost.in_doubles[0] =
            TracedInDoubles(lens, bundle, sequences[n], azimuth_rad, QualityPreset::kPreview);
        ghost.in_doubles[1] =
            TracedInDoubles(lens, bundle, sequences[n], azimuth_rad, QualityPreset::kFinal);
    });
    return ghosts;
}

void PrintMap(const Lens& lens, const Options& options, ThreadPool& threads) {
    for (const double field_deg : {0.0, 5.0, 10.0, 15.0, 20.0}) {
        for (const Ghost& ghost : MeasureGhosts(lens, field_deg, options.rays, threads)) {
            if (ghost.rays.miss_px.empty()) continue;
            std::printf("%s,%g,%d,%d,%.6f,%g,%d,%d\n", lens.name().c_str(), field_deg,
                        ghost.sequence[0], ghost.sequence[1], ghost.p999_px, LimitFor(lens),
                        ghost.in_doubles[0] ? 1 : 0, ghost.in_doubles[1] ? 1 : 0);
        }
    }
    std::fflush(stdout);
}

void PrintHead(const Options& options) {
    if (options.map) {
        std::printf("lens,field_deg,r1,r2,p999_px,limit_px,preview_in_doubles,final_in_doubles\n");
        return;
    }
    std::printf("%zu rays a ghost, light at %g degrees, %s\n\n", options.rays, options.field_deg,
                ArithmeticClass().c_str());
    std::printf(
        "| lens | EFL, mm | ghosts | median, px | p99.9, px | p99.9 past rims too, px | worst "
        "ghost's p99.9, px | ghosts above the limit | in doubles: preview, final | left in floats "
        "| p99.9 of those in floats, px | fates that differ | at most this far from an edge | lost "
        "by both, but otherwise |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
}

bool Parse(int argc, char** argv, Options& options) {
    for (int n = 1; n < argc; ++n) {
        const bool has_value = n + 1 < argc;
        if (std::strcmp(argv[n], "--rays") == 0 && has_value) {
            options.rays = static_cast<std::size_t>(std::strtoul(argv[++n], nullptr, 10));
        } else if (std::strcmp(argv[n], "--field-deg") == 0 && has_value) {
            options.field_deg = std::strtod(argv[++n], nullptr);
        } else if (std::strcmp(argv[n], "--map") == 0) {
            options.map = true;
        } else if (argv[n][0] == '-') {
            return false;
        } else {
            options.lenses.emplace_back(argv[n]);
        }
    }
    return options.rays > 0;
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    using namespace flare;
    Options options;
    if (!Parse(argc, argv, options)) {
        std::fprintf(stderr,
                     "usage: float_accuracy [--map] [--rays N] [--field-deg A] [LENS ...]\n");
        return 2;
    }
    const Result<LensLibrary> library = LensLibrary::Load(DefaultLensDirectory());
    if (!library) {
        std::fprintf(stderr, "%s\n", library.error().message.c_str());
        return 1;
    }
    if (options.lenses.empty()) options.lenses = library->Names();
    ThreadPool threads(std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
    PrintHead(options);
    for (const std::string& name : options.lenses) {
        const auto lens = library->Find(name);
        if (!lens) {
            std::fprintf(stderr, "%s\n", lens.error().message.c_str());
            return 1;
        }
        if (options.map) {
            PrintMap(**lens, options, threads);
        } else {
            std::vector<Ghost> ghosts =
                MeasureGhosts(**lens, options.field_deg, options.rays, threads);
            PrintRow(**lens, ghosts, LimitFor(**lens));
        }
    }
    return 0;
}
