// SPDX-License-Identifier: Apache-2.0
//
// The two truths and what they cost.
//
//   photon_bench agree [RAYS]         Twelve lenses of every kind, on and off axis, coated and
//   bare:
//                                     mesh reference against photons over 24 x 16 blocks of the
//                                     sensor (tests/support/photon_agreement.h).
//   photon_bench error [LENS]         One picture of 240 x 135 pixels at the d line by photons
//                                     (three estimates), by splatting a regular grid of rays and by
//                                     meshes at each preset: time and error against the dense mesh.
//
// Prints rows of a Markdown table. Threads: as many as the machine has.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "core/optics/lens_coatings.h"
#include "core/render/render_scene.h"
#include "server/lens_library.h"
#include "tests/support/photon_agreement.h"

namespace flare {
namespace {

std::shared_ptr<const Lens> Find(const LensLibrary& library, const std::string& name) {
    const Result<std::shared_ptr<const Lens>> lens = library.Find(name);
    if (!lens) {
        std::fprintf(stderr, "%s\n", lens.error().message.c_str());
        std::exit(1);
    }
    return *lens;
}

struct Kind {
    const char* lens;
    double off_deg, f_number;
};

constexpr Kind kKinds[] = {
    {"tronnier-double-gauss-50mm-f2", 12.0, 4.0},   {"canon-85mm-f1_2-spherical", 8.0, 2.0},
    {"zeiss-master-prime-50mm-t1_3", 12.0, 2.8},    {"sasian-triplet-50mm-f4", 12.0, 5.6},
    {"petzval-portrait-86mm-f3_4", 6.0, 4.0},       {"zeiss-biogon-35mm-f2_8", 20.0, 5.6},
    {"angenieux-retrofocus-35mm-f2_5", 20.0, 4.0},  {"kreitzer-telephoto-400mm-f5_6", 2.0, 8.0},
    {"canon-zoom-70-200mm-f2_8", 8.0, 5.6},         {"minolta-fisheye-16mm-f2_8", 50.0, 4.0},
    {"shimizu-fisheye-6mm-f2_8-220deg", 95.0, 4.0}, {"schneider-anamorphic-31mm-f2", 10.0, 2.8},
};

int Agree(const LensLibrary& library, std::int64_t rays) {
    std::printf(
        "| lens | field | glass | blocks | noise of a block | mean t² (expected %.2f) | "
        "σ | largest \\|t\\| | light |\n|---|---|---|---|---|---|---|---|---|\n",
        testing::kExpectedT2);
    int doubtful = 0;
    for (const Kind& kind : kKinds) {
        for (const double field : {0.0, kind.off_deg}) {
            for (const bool coated : {true, false}) {
                std::shared_ptr<const Lens> lens = Find(library, kind.lens);
                const char* glass = "coated";
                if (!coated) {
                    lens = *lens->WithCoatings({"bare", {}, {}});
                    glass = "bare";
                } else if (lens->prescription().default_coating == "bare") {
                    lens = *lens->WithCoatings({"mgf2-550", {}, {}});
                    glass = "mgf2-550";
                }
                FlareRequest request = testing::SpectralRequest(lens, kind.f_number, 24, 16);
                request.lights = {testing::LightAt(field, 30.0)};
                request.iris.blades = 7;
                testing::Studio studio(static_cast<int>(std::thread::hardware_concurrency()));
                const auto ghosts = static_cast<std::int64_t>(TwoReflectionSequences(*lens).size());
                const testing::PhotonAgreement found = testing::Agreement(
                    request, std::max<std::int64_t>(1024, rays / ghosts), 11, studio);
                std::printf("| %s | %g° | %s | %d | %.2f %% | %.2f | %+.1f | %.1f | %+.3f %% |\n",
                            kind.lens, field, glass, found.blocks, 100.0 * found.error,
                            found.mean_t2, found.sigma, found.largest_t,
                            100.0 * found.photon_over_mesh);
                std::fflush(stdout);
                if (std::abs(found.sigma) > 4.0) ++doubtful;
            }
        }
    }
    std::printf("\n%d of the rows are beyond 4 sigma.\n", doubtful);
    return 0;
}

// A regular grid of `side` x `side` rays over the front, each put down on four pixels.
FlareImage Splat(const FlareRequest& request, int side, ThreadPool& threads) {
    const RenderScene scene(request);
    const PlacedLight light = *PlaceLight(request, 0);
    const PhotonSource source(scene.lens, light);
    const SensorMap map = SensorMapOf(request);
    const auto sequences = TwoReflectionSequences(scene.lens);
    const auto width = static_cast<std::size_t>(scene.window.width);
    std::vector<std::vector<float>> parts(sequences.size());
    threads.For(static_cast<int>(sequences.size()), [&](int s) {
        std::vector<float>& part = parts[static_cast<std::size_t>(s)];
        part.assign(scene.window.pixels(), 0.0F);
        const InteractionList list = WriteOut(scene.lens, sequences[static_cast<std::size_t>(s)],
                                              request.wavelengths_nm.front());
        TraceOptions options;
        options.iris = &scene.iris;
        RayRecord record;
        for (int n = 0; n < side * side; ++n) {
            const auto start =
                source.At({(n % side + 0.5) / side, (n / side + 0.5) / side}, {0.5, 0.5});
            if (!start) continue;
            const TraceResult end = TraceRay(list, start->ray, options, &record);
            if (end.fate != RayFate::kArrived) continue;
            const double flux = start->density * source.area_mm2() /
                                (static_cast<double>(side) * side) *
                                PathWeight(scene.lens, list, record);
            const Vec2d at = map.Pixel(end.sensor_mm) - Vec2d(0.5, 0.5);
            const double x0 = std::floor(at.x), y0 = std::floor(at.y);
            for (int k = 0; k < 4; ++k) {
                const double x = x0 + k % 2, y = y0 + k / 2;
                if (x < 0 || y < 0 || x >= scene.window.width || y >= scene.window.height) continue;
                const double share = (1.0 - std::abs(at.x - x)) * (1.0 - std::abs(at.y - y));
                part[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] +=
                    static_cast<float>(flux * share);
            }
        }
    });
    std::vector<float> sum(scene.window.pixels(), 0.0F);
    const Vec2d pitch = PixelPitch(request);
    for (const std::vector<float>& part : parts) {
        for (std::size_t i = 0; i < sum.size(); ++i) {
            sum[i] += part[i] * static_cast<float>(scene.units_factor / (pitch.x * pitch.y));
        }
    }
    FlareImage image;
    image.full = image.data = scene.window;
    image.planes.push_back({scene.ChannelName(0), std::move(sum)});
    return image;
}

FlareImage RootAlone(FlareImage image) {
    image.planes.resize(1);
    return image;
}

int Errors(const LensLibrary& library, const std::string& name) {
    const int threads = static_cast<int>(std::thread::hardware_concurrency());
    FlareRequest request = testing::SpectralRequest(Find(library, name), 4.0, 240, 135);
    request.lights = {testing::LightAt(10.0, 25.0)};
    request.quality = QualityPreset::kReference;
    testing::Studio truth_studio(threads);
    const FlareImage truth = RootAlone(truth_studio.Shoot(request).image);
    const auto ghosts = TwoReflectionSequences(*request.lens).size();
    std::printf(
        "| method | rays | seconds | rel_l1 | expected of the noise |\n"
        "|---|---|---|---|---|\n");
    const auto row = [&](const std::string& method, double rays, double seconds,
                         const FlareImage& image, double expected) {
        std::printf("| %s | %.2g | %.3f | %.4f | %s |\n", method.c_str(), rays, seconds,
                    testing::RelL1(image, truth),
                    expected > 0.0 ? std::to_string(expected).substr(0, 6).c_str() : "");
        std::fflush(stdout);
    };
    const auto now = testing::Studio(1).Context().now_ms;
    ThreadPool pool(threads);
    for (int exponent = 10; exponent <= 18; exponent += 2) {
        const int side = 1 << (exponent / 2);
        for (const auto& [estimate, word] : {std::pair(PhotonEstimate::kPixel, "pixel"),
                                             std::pair(PhotonEstimate::kKernel, "kernel 2 px"),
                                             std::pair(PhotonEstimate::kNearest, "32 nearest")}) {
            FlareRequest counted = request;
            counted.photon = PhotonSpec{};
            counted.photon->samples = std::int64_t{1} << exponent;
            counted.photon->estimate = estimate;
            testing::Studio studio(threads);
            const double before = now();
            const Rendering rendering = studio.Shoot(counted);
            const PhotonFacts& facts = *rendering.report.facts.photon;
            row(std::string("photons, ") + word, static_cast<double>(facts.rays),
                (now() - before) / 1000.0, RootAlone(rendering.image), facts.rel_l1);
        }
        const double before = now();
        const FlareImage splat = Splat(request, side, pool);
        row("splatted grid, " + std::to_string(side) + "²",
            static_cast<double>(ghosts) * side * side, (now() - before) / 1000.0, splat, 0.0);
    }
    for (const auto& [preset, word] :
         {std::pair(QualityPreset::kDraft, "draft"), std::pair(QualityPreset::kPreview, "preview"),
          std::pair(QualityPreset::kFinal, "final"),
          std::pair(QualityPreset::kReference, "reference")}) {
        FlareRequest meshed = request;
        meshed.quality = preset;
        testing::Studio studio(threads);
        const double before = now();
        const Rendering rendering = studio.Shoot(meshed);
        row(std::string("mesh, ") + word, static_cast<double>(rendering.report.work.rays_traced),
            (now() - before) / 1000.0, RootAlone(rendering.image), 0.0);
    }
    return 0;
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    using namespace flare;
    const Result<LensLibrary> library = LensLibrary::Load(DefaultLensDirectory());
    if (!library) {
        std::fprintf(stderr, "%s\n", library.error().message.c_str());
        return 1;
    }
    if (argc >= 2 && std::strcmp(argv[1], "agree") == 0) {
        return Agree(*library, argc > 2 ? std::atoll(argv[2]) : 20'000'000);
    }
    if (argc >= 2 && std::strcmp(argv[1], "error") == 0) {
        return Errors(*library, argc > 2 ? argv[2] : kKinds[0].lens);
    }
    std::fputs("usage: photon_bench agree [RAYS] | error [LENS]\n", stderr);
    return 2;
}
