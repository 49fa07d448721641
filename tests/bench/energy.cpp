// SPDX-License-Identifier: Apache-2.0
//
// Does a preset keep the light? The light in the frame by each preset over that by `reference`,
// less 1: with culling, beside the share that the report says was culled; without it; and ghost by
// ghost.
//
//   energy [OPTION VALUE ...]
//     --lens NAME --field-deg A --f-number F --distance-m D --width N --height N
//     --spectral 1 (the d line alone, no colour, no tiles) --ghosts N (list the N worst)
//     --each 0 (the whole alone, not ghost by ghost)
//
// Prints rows of a Markdown table, all numbers in per cent; with `--head 1` its head as well. Of
// ghosts it tells the worst error of its own light among those with a thousandth of the frame's or
// more, and the largest part of one ghost in the error of the whole.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

#include "core/base/units.h"
#include "core/render/renderer.h"
#include "server/lens_library.h"
#include "tests/support/motion.h"
#include "tests/support/one_ghost.h"

namespace flare {
namespace {

constexpr double kCounted = 1e-3;  // of the frame's light

double NowMs() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

struct Options {
    testing::Motion scene;
    std::string lens = "tronnier-double-gauss-50mm-f2";
    double distance_m = 0.0;  // 0: infinity
    int spectral = 0, head = 0, ghosts = 0, each = 1;
};

bool Parse(int argc, char** argv, Options& options) {
    testing::Motion& scene = options.scene;
    const std::map<std::string, double*> numbers{{"--field-deg", &scene.field_deg},
                                                 {"--f-number", &scene.f_number},
                                                 {"--distance-m", &options.distance_m}};
    const std::map<std::string, int*> counts{
        {"--width", &scene.width}, {"--height", &scene.height}, {"--spectral", &options.spectral},
        {"--head", &options.head}, {"--each", &options.each},   {"--ghosts", &options.ghosts}};
    if (argc % 2 == 0) return false;
    for (int n = 1; n + 1 < argc; n += 2) {
        const std::string name = argv[n];
        if (numbers.contains(name)) {
            *numbers.at(name) = std::strtod(argv[n + 1], nullptr);
        } else if (counts.contains(name)) {
            *counts.at(name) = std::atoi(argv[n + 1]);
        } else if (name == "--lens") {
            options.lens = argv[n + 1];
        } else {
            return false;
        }
    }
    return scene.width > 0 && scene.height > 0;
}

struct Shot {
    double light = 0.0;
    double culled = 0.0;                  // share of the light, by the report
    std::map<BounceSequence, double> of;  // each ghost's light
};

class Energies {
  public:
    Energies(Options options, ThreadPool& threads)
        : options_(std::move(options)), threads_(threads) {
        request_ = testing::FrameOf(Standing(), 0);
        if (options_.distance_m > 0.0) request_.lights[0].distance_m = options_.distance_m;
        if (options_.spectral != 0) {
            request_.color = ColorMode::kSpectral;
            request_.wavelengths_nm = {kLineD};
        }
    }

    void Run() {
        if (options_.head != 0) {
            std::printf(
                "| lens | f-number | preset | energy | culled | beyond | energy, all drawn "
                "| worst ghost | most of the whole |\n|---|---|---|---|---|---|---|---|---|\n");
        }
        const Shot truth = Take(QualityPreset::kReference, CullingRule::kNone, options_.each != 0);
        for (const auto& [preset, name] : {std::pair(QualityPreset::kDraft, "draft"),
                                           std::pair(QualityPreset::kPreview, "preview"),
                                           std::pair(QualityPreset::kFinal, "final")}) {
            const Shot culled = Take(preset, CullingRule::kAuto, false);
            const Shot all = Take(preset, CullingRule::kNone, options_.each != 0);
            Print(name, truth, culled, all);
        }
    }

  private:
    // The light where it is asked for.
    testing::Motion Standing() const {
        testing::Motion scene = options_.scene;
        scene.moving = testing::Moving::kIris;
        scene.from = scene.f_number;
        return scene;
    }

    double LightOf(QualityPreset preset, CullingRule culling, double* share_culled) {
        request_.quality = preset;
        request_.model.culling = culling;
        const Result<Rendering> rendering =
            Render(request_, {threads_, meshes_, CancelToken(), NowMs});
        if (!rendering) {
            std::fprintf(stderr, "%s\n", rendering.error().message.c_str());
            std::exit(1);
        }
        if (share_culled) *share_culled = rendering->report.facts.estimated_error.culling;
        double light = 0.0;
        for (std::size_t p = 0; p < rendering->image.planes.size() / 2; ++p) {
            for (const float value : rendering->image.planes[p].values)
                light += static_cast<double>(value);
        }
        return light;
    }

    Shot Take(QualityPreset preset, CullingRule culling, bool each) {
        Shot shot;
        meshes_.Show(std::nullopt);
        shot.light = LightOf(preset, culling, &shot.culled);
        if (each) {
            for (const BounceSequence& sequence : TwoReflectionSequences(*request_.lens)) {
                meshes_.Show(sequence);
                shot.of[sequence] = LightOf(preset, culling, nullptr);
            }
        }
        meshes_.Forget();
        return shot;
    }

    void Print(const char* preset, const Shot& truth, const Shot& culled, const Shot& all) const {
        std::vector<std::pair<double, BounceSequence>> parts;  // of the whole's error
        double worst = 0.0;
        BounceSequence worst_ghost{0, 0};
        for (const auto& [sequence, light] : all.of) {
            const double true_light = truth.of.at(sequence);
            parts.emplace_back((light - true_light) / truth.light, sequence);
            if (true_light < kCounted * truth.light) continue;
            const double own = light / true_light - 1.0;
            if (std::abs(own) > std::abs(worst)) {
                worst = own;
                worst_ghost = sequence;
            }
        }
        if (parts.empty()) parts.emplace_back(0.0, worst_ghost);
        std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
            return std::abs(a.first) > std::abs(b.first);
        });
        const double energy = culled.light / truth.light - 1.0;
        std::printf(
            "| %s | %g | %s | %+.4f | %.4f | %+.4f | %+.4f | %+.3f (%d, %d) | %+.4f (%d, %d) "
            "|\n",
            options_.lens.c_str(), options_.scene.f_number, preset, 100.0 * energy,
            100.0 * culled.culled, 100.0 * (energy + culled.culled),
            100.0 * (all.light / truth.light - 1.0), 100.0 * worst, worst_ghost[0], worst_ghost[1],
            100.0 * parts[0].first, parts[0].second[0], parts[0].second[1]);
        const int listed = options_.each != 0 ? options_.ghosts : 0;
        for (std::size_t n = 0; n < parts.size() && static_cast<int>(n) < listed; ++n) {
            const BounceSequence& s = parts[n].second;
            std::printf("    (%d, %d): share %.3f, own error %+.4f, part of the whole's %+.5f\n",
                        s[0], s[1], 100.0 * truth.of.at(s) / truth.light,
                        100.0 * (all.of.at(s) / truth.of.at(s) - 1.0), 100.0 * parts[n].first);
        }
        std::fflush(stdout);
    }

    Options options_;
    ThreadPool& threads_;
    testing::OneGhostMeshes meshes_;
    FlareRequest request_;
};

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    using namespace flare;
    Options options;
    if (!Parse(argc, argv, options)) {
        std::fputs(
            "usage: energy [--lens NAME] [--field-deg A] [--f-number F] [--distance-m D]\n"
            "  [--width N] [--height N] [--spectral 1] [--head 1] [--ghosts N] [--each 0]\n",
            stderr);
        return 2;
    }
    const Result<LensLibrary> library = LensLibrary::Load(DefaultLensDirectory());
    const Result<std::shared_ptr<const Lens>> lens =
        library ? library->Find(options.lens) : library.error();
    if (!lens) {
        std::fprintf(stderr, "%s\n", lens.error().message.c_str());
        return 1;
    }
    options.scene.lens = *lens;
    ThreadPool threads(std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
    Energies(std::move(options), threads).Run();
    return 0;
}
