// SPDX-License-Identifier: Apache-2.0
//
// Does a moving picture pop? Renders a sweep frame by frame and writes, as CSV, how much each frame
// differs from the one before (sum |E - Eb| / sum |Eb|), beside what was culled and drawn. Frames
// that change by more than three times the median are rendered again, with the frame before, in the
// `reference` preset: what jumps there as well is the lens.
//
//   motion [light|iris|zoom|focus|distance] [OPTION VALUE ...] > sweep.csv
//
// The summary goes to stderr. plot.py draws the CSV.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <thread>

#include "core/render/renderer.h"
#include "server/cache/mesh_cache.h"
#include "server/lens_library.h"
#include "tests/support/motion.h"

namespace flare {
namespace {

constexpr const char* kUsage =
    "usage: motion [light|iris|zoom|focus|distance] [OPTION VALUE ...]\n"
    "  --lens NAME --preset draft|preview|final --width N --height N --frames N\n"
    "  --from VALUE --step VALUE --field-deg A --azimuth-deg A --f-number F\n"
    "  --culling auto|none  --references N (most frames rendered in `reference`, default 8)\n";

double NowMs() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

struct Options {
    testing::Motion motion;
    std::string lens = "tronnier-double-gauss-50mm-f2";
    CullingRule culling = CullingRule::kAuto;
    int frames = 501;
    int references = 8;
};

// Each sweep as the issue of smooth motion has it.
bool StartSweep(const std::string& name, Options& options) {
    testing::Motion& motion = options.motion;
    if (name == "light") {
        motion.moving = testing::Moving::kLight;
    } else if (name == "iris") {
        motion.moving = testing::Moving::kIris;
        motion.from = 2.04;
        options.frames = 208;
    } else if (name == "zoom") {
        motion.moving = testing::Moving::kZoom;
        motion.from = 72.0;
        motion.f_number = 8.0;
        options.lens = "canon-zoom-70-200mm-f2_8";
        options.frames = 100;
    } else if (name == "focus") {
        motion.moving = testing::Moving::kFocus;
        motion.from = 100.0;
        options.frames = 100;
    } else if (name == "distance") {
        motion.moving = testing::Moving::kDistance;
        motion.from = 100.0;
        motion.step = 0.02;
        options.frames = 100;
    } else {
        return false;
    }
    return true;
}

bool Parse(int argc, char** argv, Options& options) {
    if (argc < 2 || !StartSweep(argv[1], options) || argc % 2 != 0) return false;
    testing::Motion& motion = options.motion;
    const std::map<std::string, double*> numbers{{"--from", &motion.from},
                                                 {"--step", &motion.step},
                                                 {"--field-deg", &motion.field_deg},
                                                 {"--azimuth-deg", &motion.azimuth_deg},
                                                 {"--f-number", &motion.f_number}};
    const std::map<std::string, int*> counts{{"--width", &motion.width},
                                             {"--height", &motion.height},
                                             {"--frames", &options.frames},
                                             {"--references", &options.references}};
    const std::map<std::string, QualityPreset> presets{{"draft", QualityPreset::kDraft},
                                                       {"preview", QualityPreset::kPreview},
                                                       {"final", QualityPreset::kFinal},
                                                       {"reference", QualityPreset::kReference}};
    for (int n = 2; n + 1 < argc; n += 2) {
        const std::string name = argv[n], value = argv[n + 1];
        if (numbers.contains(name)) {
            *numbers.at(name) = std::strtod(value.c_str(), nullptr);
        } else if (counts.contains(name)) {
            *counts.at(name) = std::atoi(value.c_str());
        } else if (name == "--preset" && presets.contains(value)) {
            motion.quality = presets.at(value);
        } else if (name == "--lens") {
            options.lens = value;
        } else if (name == "--culling" && (value == "auto" || value == "none")) {
            options.culling = value == "auto" ? CullingRule::kAuto : CullingRule::kNone;
        } else {
            return false;
        }
    }
    return options.frames > 2 && motion.width > 0 && motion.height > 0;
}

class Sweep {
  public:
    Sweep(Options options, ThreadPool& threads) : options_(std::move(options)), threads_(threads) {}

    int Run() {
        FlareImage before;
        std::vector<Frame> frames;
        for (int n = 0; n < options_.frames; ++n) {
            Result<Rendering> rendering = Shoot(n, options_.motion.quality);
            if (!rendering) {
                std::fprintf(stderr, "%s\n", rendering.error().message.c_str());
                return 1;
            }
            Frame& frame = frames.emplace_back();
            frame.facts = rendering->report.facts;
            frame.work = rendering->report.work;
            for (std::size_t p = 0; p < 3; ++p) {
                for (const float value : rendering->image.planes[p].values)
                    frame.light += static_cast<double>(value);
            }
            if (n > 0) frame.change = testing::ChangeFrom(before, rendering->image);
            before = std::move(rendering->image);
        }
        std::vector<double> changes;
        for (std::size_t n = 1; n < frames.size(); ++n) changes.push_back(frames[n].change);
        const double median = testing::Median(changes);
        CompareWithReference(median, frames);
        Print(median, frames);
        return 0;
    }

  private:
    struct Frame {
        Facts facts;
        Work work;
        double light = 0.0, change = 0.0;
        std::optional<double> reference_change;
    };

    Result<Rendering> Shoot(int frame, QualityPreset quality) {
        FlareRequest request = testing::FrameOf(options_.motion, frame);
        request.quality = quality;
        request.model.culling = options_.culling;
        return Render(request, {threads_, cache_, CancelToken(), NowMs});
    }

    // The largest jumps first, as many as are asked for.
    void CompareWithReference(double median, std::vector<Frame>& frames) {
        std::vector<std::size_t> jumps;
        for (std::size_t n = 1; n < frames.size(); ++n) {
            if (frames[n].change > 3.0 * median) jumps.push_back(n);
        }
        std::sort(jumps.begin(), jumps.end(), [&](std::size_t a, std::size_t b) {
            return frames[a].change > frames[b].change;
        });
        jumps.resize(std::min(jumps.size(), static_cast<std::size_t>(options_.references)));
        for (const std::size_t n : jumps) {
            const auto frame = static_cast<int>(n);
            const Result<Rendering> before = Shoot(frame - 1, QualityPreset::kReference);
            const Result<Rendering> after = Shoot(frame, QualityPreset::kReference);
            if (!before || !after) continue;
            frames[n].reference_change = testing::ChangeFrom(before->image, after->image);
        }
    }

    void Print(double median, const std::vector<Frame>& frames) const {
        std::printf(
            "frame,value,change,reference_change,light,culled,faded,lost_share,drawn,pieces,"
            "rays,ms\n");
        double largest = 0.0;
        std::size_t above = 0, at = 0;
        for (std::size_t n = 0; n < frames.size(); ++n) {
            const Frame& f = frames[n];
            const CullingFacts& culling = f.facts.culling;
            std::printf("%zu,%.6g,%.6g,%s,%.8g,%llu,%llu,%.5g,%zu,%llu,%llu,%.1f\n", n,
                        testing::MovedValue(options_.motion, static_cast<int>(n)), f.change,
                        f.reference_change ? std::to_string(*f.reference_change).c_str() : "",
                        f.light, static_cast<unsigned long long>(culling.culled),
                        static_cast<unsigned long long>(culling.faded),
                        f.facts.estimated_error.culling,
                        f.facts.ghosts.size() - static_cast<std::size_t>(culling.culled),
                        static_cast<unsigned long long>(f.work.polygons),
                        static_cast<unsigned long long>(f.work.rays_traced),
                        f.work.setup_ms + f.work.cull_ms + f.work.mesh_ms + f.work.raster_ms +
                            f.work.resolve_ms);
            if (f.change > largest) {
                largest = f.change;
                at = n;
            }
            above += f.change > 3.0 * median ? 1 : 0;
        }
        std::fprintf(
            stderr,
            "median %.5g, largest %.5g (%.2f times) at frame %zu (%.6g); %zu of %zu above 3 "
            "times\n",
            median, largest, largest / median, at,
            testing::MovedValue(options_.motion, static_cast<int>(at)), above, frames.size() - 1);
        for (std::size_t n = 0; n < frames.size(); ++n) {
            if (!frames[n].reference_change) continue;
            std::fprintf(stderr, "frame %zu: %.5g, in reference %.5g (%.2f times the median)\n", n,
                         frames[n].change, *frames[n].reference_change,
                         *frames[n].reference_change / median);
        }
    }

    Options options_;
    ThreadPool& threads_;
    MeshCache cache_{std::size_t{1} << 30};
};

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    using namespace flare;
    Options options;
    if (!Parse(argc, argv, options)) {
        std::fputs(kUsage, stderr);
        return 2;
    }
    const Result<LensLibrary> library = LensLibrary::Load(DefaultLensDirectory());
    const Result<std::shared_ptr<const Lens>> lens =
        library ? library->Find(options.lens) : library.error();
    if (!lens) {
        std::fprintf(stderr, "%s\n", lens.error().message.c_str());
        return 1;
    }
    options.motion.lens = *lens;
    ThreadPool threads(std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
    return Sweep(std::move(options), threads).Run();
}
