// SPDX-License-Identifier: Apache-2.0
//
// What the program's work costs on this machine, case by case, with the seed lens as its file has
// it (coated). Rates are per second of wall time; `rel_l1` cases stand in docs/performance.md
// beside their command. Compare cases within one run only.
#include <benchmark/benchmark.h>

#include <chrono>
#include <string>
#include <thread>

#include "core/image/exr.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/quality.h"
#include "core/render/renderer.h"
#include "core/spectrum/wavelength_plan.h"
#include "server/cache/mesh_cache.h"
#include "server/service.h"

namespace flare {
namespace {

constexpr double kField_rad = 0.0872664625997165;  // 5 degrees

double NowMs() {
    return std::chrono::duration<double, std::milli>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

int Threads() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

const std::shared_ptr<const Lens>& SeedLens() {
    static const std::shared_ptr<const Lens> lens =
        LoadLensFile(std::string(FLARE_SOURCE_DIR) + "/lenses/tronnier-double-gauss-50mm-f2.toml")
            .value();
    return lens;
}

benchmark::Counter Rate(double count) {
    return {count, benchmark::Counter::kIsRate};
}

// The reference tracer: all 45 ghosts, a 32 x 32 grid over the front, one thread, nothing recorded.
void TraceSeedLens(benchmark::State& state) {
    const Lens& lens = *SeedLens();
    const LightBundle bundle(lens, kField_rad, 0.0);
    std::vector<InteractionList> lists;
    for (const BounceSequence& s : TwoReflectionSequences(lens))
        lists.push_back(WriteOut(lens, s, kLineD));
    TraceOptions options;
    options.clip = false;
    double rays = 0.0;
    double ray_surfaces = 0.0;
    RayRecord record;
    for (auto _ : state) {
        for (const InteractionList& list : lists) {
            for (int i = 0; i < 32 * 32; ++i) {
                const double u = 11.0 * ((i % 32) / 15.5 - 1.0);
                const double v = 11.0 * ((i / 32) / 15.5 - 1.0);
                const TraceResult result = TraceRay(list, bundle.At(u, v), options, nullptr);
                benchmark::DoNotOptimize(result);
                rays += 1.0;
                ray_surfaces += result.ended_at < 0 ? static_cast<double>(list.steps.size())
                                                    : result.ended_at + 1.0;
            }
        }
    }
    state.counters["rays"] = Rate(rays);
    state.counters["ray_surfaces"] = Rate(ray_surfaces);
}

// All 45 meshes of a preview, traced afresh on all threads.
void MeshSeedLensCold(benchmark::State& state) {
    const Lens& lens = *SeedLens();
    const QualitySettings settings = SettingsOf(QualityPreset::kPreview);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(lens);
    ThreadPool threads(Threads());
    std::vector<GhostMesh> meshes(sequences.size());
    double rays = 0.0;
    double ray_surfaces = 0.0;
    double bytes = 0.0;
    for (auto _ : state) {
        threads.For(static_cast<int>(sequences.size()), [&](int i) {
            MeshSpec spec;
            spec.sequence = sequences[static_cast<std::size_t>(i)];
            spec.field_rad = kField_rad;
            spec.wavelengths_nm =
                ChebyshevNodes(kTracedLow_nm, kTracedHigh_nm, settings.traced_wavelengths);
            spec.cells = settings.mesh_cells;
            spec.patch_cells = settings.patch_cells;
            spec.position_tolerance_mm = settings.position_tolerance_mm;
            spec.mask_tolerance = settings.mask_tolerance;
            meshes[static_cast<std::size_t>(i)] = BuildMesh(lens, spec);
        });
        bytes = 0.0;
        for (const GhostMesh& mesh : meshes) {
            rays += static_cast<double>(mesh.rays_traced);
            ray_surfaces += static_cast<double>(mesh.ray_surfaces);
            bytes += static_cast<double>(mesh.bytes());
        }
    }
    state.counters["rays"] = Rate(rays);
    state.counters["ray_surfaces"] = Rate(ray_surfaces);
    state.counters["mesh_bytes"] = bytes;
}

FlareRequest SeedRequest(double f_number) {
    FlareRequest request;
    request.lens = SeedLens();
    request.f_number = f_number;
    request.image.width = 1920;
    request.image.height = 1080;
    LightSpec light;
    light.direction = Vec3d(-std::sin(kField_rad), 0.0, std::cos(kField_rad));
    request.lights.push_back(light);
    return request;
}

// A preview with its meshes in the cache, to planes of floats.
void RenderWarm(benchmark::State& state, double f_number) {
    ThreadPool threads(Threads());
    MeshCache cache(std::size_t{1} << 30);
    const RenderContext context{threads, cache, CancelToken(), NowMs};
    const FlareRequest request = SeedRequest(f_number);
    if (!Render(request, context)) {
        state.SkipWithError("the request was refused");
        return;
    }
    double polygons = 0.0;
    double fragments = 0.0;
    double rays = 0.0;
    for (auto _ : state) {
        const Result<Rendering> rendering = Render(request, context);
        rays += static_cast<double>(rendering->report.work.rays_traced);
        polygons += static_cast<double>(rendering->report.work.polygons);
        fragments += static_cast<double>(rendering->report.work.fragments);
    }
    state.counters["rays"] = Rate(rays);
    state.counters["polygons"] = Rate(polygons);
    state.counters["fragments"] = Rate(fragments);
}

void EncodeZip(benchmark::State& state) {
    ThreadPool threads(Threads());
    TracingMeshProvider meshes;
    FlareRequest request = SeedRequest(4.0);
    request.quality = QualityPreset::kDraft;
    const Result<Rendering> rendering = Render(request, {threads, meshes, CancelToken(), NowMs});
    SetExrThreads(Threads());
    double bytes = 0.0;
    for (auto _ : state) {
        bytes = static_cast<double>(EncodeExr(rendering->image, {}).bytes.size());
    }
    state.counters["file_bytes"] = bytes;
    state.counters["pixels"] = Rate(1920.0 * 1080.0 * static_cast<double>(state.iterations()));
}

// From the body of a request to the bytes of its reply, meshes in the cache.
void RequestWarm(benchmark::State& state) {
    const Result<LensLibrary> library =
        LensLibrary::Load(std::string(FLARE_SOURCE_DIR) + "/lenses");
    ThreadPool threads(Threads());
    SetExrThreads(Threads());
    MeshCache cache(std::size_t{1} << 30);
    const ServiceContext context{*library, threads, cache, CancelToken(), NowMs};
    const std::string body = R"({"lens": "tronnier-double-gauss-50mm-f2", "f_number": 4,
        "image": {"width": 1920, "height": 1080, "sensor_width_mm": 36},
        "lights": [{"direction": [-0.0872, 0, 0.9962], "irradiance": [1, 1, 1]}]})";
    const Result<ServiceReply> first = ServeFlare(body, ReplyFormat::kExr, "", context);
    if (!first) {
        state.SkipWithError((first.error().where + ": " + first.error().message).c_str());
        return;
    }
    double bytes = 0.0;
    for (auto _ : state) {
        bytes = static_cast<double>(ServeFlare(body, ReplyFormat::kExr, "", context)->bytes.size());
    }
    state.counters["reply_bytes"] = bytes;
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    using benchmark::RegisterBenchmark;
    const auto milliseconds = benchmark::kMillisecond;
    RegisterBenchmark("trace/seed_lens", flare::TraceSeedLens)->Unit(milliseconds);
    RegisterBenchmark("mesh/seed_lens_cold", flare::MeshSeedLensCold)
        ->Unit(milliseconds)
        ->UseRealTime();
    RegisterBenchmark("render/seed_f4_1080p_warm", flare::RenderWarm, 4.0)
        ->Unit(milliseconds)
        ->UseRealTime();
    RegisterBenchmark("render/seed_f2_1080p_warm", flare::RenderWarm, 2.0)
        ->Unit(milliseconds)
        ->UseRealTime();
    RegisterBenchmark("exr/1080p_zip", flare::EncodeZip)->Unit(milliseconds)->UseRealTime();
    RegisterBenchmark("request/seed_f4_1080p_warm", flare::RequestWarm)
        ->Unit(milliseconds)
        ->UseRealTime();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
