// SPDX-License-Identifier: Apache-2.0
//
// Disc-shaped lights against brute force: the same renderer, preset and picture, with the disc
// taken apart into points, `side` x `side` equal parts of it (concentric map). Ghosts only. For
// every lens of the library (or those named), a light in the middle of the frame and one in its
// corner. Prints one line a case for docs/physics/area-lights.md:
//
//   area_light [--side N] [--diameter-deg D] [--preset NAME] [--width W] [--height H]
//              [--f-number F] [--place centre|corner] [LENS ...]
//
// rel_l1 is against the points; `point` is what a point in place of the disc would be wrong by.
// Times are of the processor, all threads together, in the second rendering of each: meshes kept.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "core/base/keep_memory.h"
#include "core/base/units.h"
#include "core/render/compare.h"
#include "core/render/renderer.h"
#include "server/cache/mesh_cache.h"
#include "server/lens_library.h"

namespace flare {
namespace {

struct Options {
    int side = 16, width = 480, height = 270;
    double diameter_deg = 0.53, f_number = 8.0;
    QualityPreset quality = QualityPreset::kPreview;
    std::string place;
    std::vector<std::string> lenses;
};

double NowMs() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

double ProcessorMs() {
    return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Shot {
    Rendering rendering;
    double ms = 0.0;
};

class Bench {
  public:
    explicit Bench(Options options)
        : options_(std::move(options)),
          threads_(static_cast<int>(std::max(1U, std::thread::hardware_concurrency()))) {}

    int Run() {
        const Result<LensLibrary> library = LensLibrary::Load(DefaultLensDirectory());
        if (!library) {
            std::fprintf(stderr, "%s\n", library.error().message.c_str());
            return 1;
        }
        const std::vector<std::string> names =
            options_.lenses.empty() ? library->Names() : options_.lenses;
        std::printf(
            "lens,place,rel_l1,blur2,energy,point,estimated,blurred,directions,ms,point_ms\n");
        for (const std::string& name : names) {
            const auto lens = library->Find(name);
            if (!lens) {
                std::fprintf(stderr, "%s: %s\n", name.c_str(), lens.error().message.c_str());
                return 1;
            }
            for (const char* place : {"centre", "corner"}) {
                if (options_.place.empty() || options_.place == place) Case(*lens, place);
            }
        }
        return 0;
    }

  private:
    FlareRequest RequestFor(const std::shared_ptr<const Lens>& lens, const std::string& place) {
        FlareRequest request;
        request.lens = lens;
        request.f_number = options_.f_number;
        request.iris = {6, 0.0, 10.0};
        request.image.width = options_.width;
        request.image.height = options_.height;
        request.quality = options_.quality;
        LightSpec& light = request.lights.emplace_back();
        const double to_corner = place == "corner" ? 0.95 : 0.0;
        light.pixel = Vec2d(0.5 * options_.width * (1.0 - to_corner),
                            0.5 * options_.height * (1.0 - to_corner));
        return request;
    }

    // The second of two, so that meshes are known.
    Result<Shot> Shoot(const FlareRequest& request) {
        MeshCache cache(std::size_t{1} << 30);
        Result<Rendering> first = Render(request, {threads_, cache, CancelToken(), NowMs});
        if (!first) return first.error();
        const double before = ProcessorMs();
        Result<Rendering> second = Render(request, {threads_, cache, CancelToken(), NowMs});
        return Shot{std::move(*second), ProcessorMs() - before};
    }

    // Directions over the disc about the light's own, by the concentric map.
    std::vector<Vec3d> Directions(const Vec3d& middle) const {
        const Vec3d aside = std::abs(middle.x) < 0.5 ? Vec3d(1.0, 0.0, 0.0) : Vec3d(0.0, 1.0, 0.0);
        const Vec3d e1 = middle.cross(aside).normalized();
        const Vec3d e2 = middle.cross(e1);
        const double radius = RadiansFromDegrees(0.5 * options_.diameter_deg);
        std::vector<Vec3d> directions;
        for (int k = 0; k < options_.side * options_.side; ++k) {
            const double a = 2.0 * (k % options_.side + 0.5) / options_.side - 1.0;
            const double b = 2.0 * (k / options_.side + 0.5) / options_.side - 1.0;
            const bool wide = std::abs(a) > std::abs(b);
            const double r = wide ? a : b;
            const double angle =
                r == 0.0 ? 0.0 : (wide ? 0.25 * kPi * b / a : 0.5 * kPi - 0.25 * kPi * a / b);
            const Vec3d across = (e1 * std::cos(angle) + e2 * std::sin(angle)) * r;
            directions.push_back(middle * std::cos(radius * across.length()) +
                                 across *
                                     (across.length() > 0.0
                                          ? std::sin(radius * across.length()) / across.length()
                                          : 0.0));
        }
        return directions;
    }

    void Case(const std::shared_ptr<const Lens>& lens, const std::string& place) {
        FlareRequest request = RequestFor(lens, place);
        const Result<Shot> point = Shoot(request);
        if (!point) {
            std::printf("%s,%s,%s\n", lens->name().c_str(), place.c_str(),
                        point.error().message.c_str());
            return;
        }
        request.lights[0].angular_diameter_deg = options_.diameter_deg;
        const Result<Shot> disc = Shoot(request);
        const Vec3d middle = point->rendering.report.facts.lights[0].direction;
        FlareRequest points = request;
        points.lights.clear();
        const std::vector<Vec3d> directions = Directions(middle);
        for (const Vec3d& direction : directions) {
            LightSpec& light = points.lights.emplace_back();
            light.direction = direction;
            light.irradiance = Vec3d(1.0 / static_cast<double>(directions.size()));
        }
        TracingMeshProvider none;
        const Result<Rendering> truth = Render(points, {threads_, none, CancelToken(), NowMs});
        const ErrorMetrics of_disc = Compare(disc->rendering.image, truth->image)->all;
        const ErrorMetrics of_point = Compare(point->rendering.image, truth->image)->all;
        int blurred = 0, most = 0;
        for (const GhostFacts& ghost : disc->rendering.report.facts.ghosts) {
            blurred += ghost.source_directions > 0 ? 1 : 0;
            most += ghost.source_directions;
        }
        std::printf("%s,%s,%.5f,%.5f,%.5f,%.4f,%.4f,%d,%d,%.1f,%.1f\n", lens->name().c_str(),
                    place.c_str(), of_disc.rel_l1, of_disc.rel_l2_blur2, of_disc.energy,
                    of_point.rel_l1, disc->rendering.report.facts.estimated_error.rel_l1, blurred,
                    most, disc->ms, point->ms);
        std::fflush(stdout);
    }

    Options options_;
    ThreadPool threads_;
};

bool Parse(int argc, char** argv, Options& options) {
    const std::map<std::string, int*> counts{
        {"--side", &options.side}, {"--width", &options.width}, {"--height", &options.height}};
    const std::map<std::string, double*> numbers{{"--diameter-deg", &options.diameter_deg},
                                                 {"--f-number", &options.f_number}};
    const std::map<std::string, QualityPreset> presets{{"draft", QualityPreset::kDraft},
                                                       {"preview", QualityPreset::kPreview},
                                                       {"final", QualityPreset::kFinal},
                                                       {"reference", QualityPreset::kReference}};
    for (int n = 1; n < argc; ++n) {
        const std::string name = argv[n];
        if (name.rfind("--", 0) != 0) {
            options.lenses.push_back(name);
            continue;
        }
        if (++n >= argc) return false;
        const std::string value = argv[n];
        if (counts.contains(name)) {
            *counts.at(name) = std::atoi(value.c_str());
        } else if (numbers.contains(name)) {
            *numbers.at(name) = std::strtod(value.c_str(), nullptr);
        } else if (name == "--preset" && presets.contains(value)) {
            options.quality = presets.at(value);
        } else if (name == "--place") {
            options.place = value;
        } else {
            return false;
        }
    }
    return options.side > 0 && options.width > 0 && options.height > 0;
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    flare::KeepFreedMemory();
    flare::Options options;
    if (!flare::Parse(argc, argv, options)) {
        std::fprintf(stderr,
                     "usage: area_light [--side N] [--diameter-deg D] [--preset NAME] [--width W] "
                     "[--height H] [--f-number F] [--place centre|corner] [LENS ...]\n");
        return 2;
    }
    return flare::Bench(options).Run();
}
