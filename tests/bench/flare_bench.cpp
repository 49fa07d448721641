// SPDX-License-Identifier: Apache-2.0
//
// What the program's work costs on this machine, case by case, with the seed lens as its file has
// it (coated). Rates are per second of wall time. Compare cases within one run only. The first of
// the render cases with one lens and f-number has to render the converged picture, which takes from
// a minute to many: choose cases with --benchmark_filter.
#include <OpenEXR/ImfThreading.h>
#include <benchmark/benchmark.h>
#include <libdeflate.h>

#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "core/base/keep_memory.h"
#include "core/image/exr.h"
#include "core/image/line_deflate.h"
#include "core/image/preview.h"
#include "core/mesh/mesh_builder.h"
#include "core/mesh/pass_region.h"
#include "core/render/compare.h"
#include "core/render/light_meshes.h"
#include "core/render/quality.h"
#include "core/render/renderer.h"
#include "core/spectrum/wavelength_plan.h"
#include "core/tracing/trace_columns.h"
#include "server/cache/ghost_cache.h"
#include "server/cache/mesh_cache.h"
#include "server/service.h"
#include "tests/support/library_exr.h"

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

// All 45 ghosts of the seed lens with bare glass, a 64 x 64 grid over each one's pass region, one
// thread, with everything recorded that a mesh keeps.
struct GhostRays {
    InteractionList list;
    std::vector<Ray> rays;
};

std::vector<GhostRays> SeedRays() {
    const std::shared_ptr<const Lens> lens = SeedLens()->WithBareGlass();
    const LightBundle bundle(*lens, kField_rad, 0.0);
    std::vector<GhostRays> ghosts;
    for (const BounceSequence& sequence : TwoReflectionSequences(*lens)) {
        GhostRays& ghost = ghosts.emplace_back();
        ghost.list = WriteOut(*lens, sequence, kLineD);
        const PassRegion region = FindPassRegion({ghost.list}, bundle);
        if (!region.rect) continue;
        const Rect& r = *region.rect;
        for (int k = 0; k < 64 * 64; ++k) {
            ghost.rays.push_back(bundle.AtFront(r.u0 + (r.u1 - r.u0) * (k % 64 + 0.5) / 64.0,
                                                r.v0 + (r.v1 - r.v0) * (k / 64 + 0.5) / 64.0));
        }
    }
    return ghosts;
}

void TraceSeedReference(benchmark::State& state) {
    const std::vector<GhostRays> ghosts = SeedRays();
    TraceOptions options;
    options.clip = false;
    double ray_surfaces = 0.0;
    RayRecord record;
    for (auto _ : state) {
        for (const GhostRays& ghost : ghosts) {
            for (const Ray& ray : ghost.rays) {
                const TraceResult result = TraceRay(ghost.list, ray, options, &record);
                benchmark::DoNotOptimize(result);
            }
            ray_surfaces += static_cast<double>(ghost.rays.size() * ghost.list.steps.size());
        }
    }
    state.counters["ray_surfaces"] = Rate(ray_surfaces);
}

void TraceSeedSimd(benchmark::State& state) {
    const std::vector<GhostRays> ghosts = SeedRays();
    std::vector<RayColumns> rays(ghosts.size());
    for (std::size_t n = 0; n < ghosts.size(); ++n) {
        rays[n].Resize(ghosts[n].rays.size());
        for (std::size_t k = 0; k < rays[n].size(); ++k)
            rays[n].Set(k, ghosts[n].rays[k].origin, ghosts[n].rays[k].direction);
    }
    TraceColumns out;
    double ray_surfaces = 0.0;
    for (auto _ : state) {
        for (std::size_t n = 0; n < ghosts.size(); ++n) {
            TraceInColumns(ghosts[n].list, rays[n], {}, out);
            benchmark::DoNotOptimize(out.exit_x.data());
            ray_surfaces += static_cast<double>(rays[n].size() * ghosts[n].list.steps.size());
        }
    }
    state.counters["ray_surfaces"] = Rate(ray_surfaces);
}

// All meshes of a preview, traced afresh on all threads.
void MeshCold(benchmark::State& state, const std::string& name) {
    const std::shared_ptr<const Lens> lens =
        LoadLensFile(std::string(FLARE_SOURCE_DIR) + "/lenses/" + name + ".toml").value();
    const QualitySettings settings = SettingsOf(QualityPreset::kPreview);
    const std::vector<BounceSequence> sequences = TwoReflectionSequences(*lens);
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
            SetQuality(settings, spec);
            meshes[static_cast<std::size_t>(i)] = BuildMesh(*lens, spec);
        });
        bytes = 0.0;
        for (const GhostMesh& mesh : meshes) {
            rays += static_cast<double>(mesh.rays_traced);
            ray_surfaces += static_cast<double>(mesh.ray_surfaces);
            bytes += static_cast<double>(mesh.bytes());
        }
    }
    state.counters["ghosts"] = static_cast<double>(sequences.size());
    state.counters["rays"] = Rate(rays);
    state.counters["ray_surfaces"] = Rate(ray_surfaces);
    state.counters["mesh_bytes"] = bytes;
}

FlareRequest LightRequest(std::shared_ptr<const Lens> lens, double f_number) {
    FlareRequest request;
    request.lens = std::move(lens);
    request.f_number = f_number;
    request.image.width = 1920;
    request.image.height = 1080;
    LightSpec light;
    light.direction = Vec3d(-std::sin(kField_rad), 0.0, std::cos(kField_rad));
    request.lights.push_back(light);
    return request;
}

FlareRequest SeedRequest(double f_number) {
    return LightRequest(SeedLens(), f_number);
}

// A zoom of 33 surfaces, 528 ghosts, at its shortest.
FlareRequest ZoomRequest() {
    static const std::shared_ptr<const Lens> lens =
        LoadLensFile(std::string(FLARE_SOURCE_DIR) + "/lenses/canon-zoom-70-200mm-f2_8.toml")
            .value();
    return LightRequest(lens, lens->f_number());
}

// The converged picture of a request, rendered once a run however many cases ask for it.
const FlareImage& Converged(const std::string& name, FlareRequest request) {
    static std::map<std::string, FlareImage> images;
    const auto known = images.find(name);
    if (known != images.end()) return known->second;
    ThreadPool threads(Threads());
    TracingMeshProvider meshes;
    request.quality = QualityPreset::kReference;
    return images
        .emplace(name, Render(request, {threads, meshes, CancelToken(), NowMs}).value().image)
        .first->second;
}

// What a picture finds of the one before: its meshes, or the ghosts as they were drawn as well.
enum class Known { kMeshes, kGhosts };

// To planes of floats. A time without its error is worth nothing:
// `rel_l1` and `energy` are measured against the converged picture, outside the timing;
// `estimated` is what the report says.
void RenderWarm(benchmark::State& state, const std::string& name, FlareRequest request,
                QualityPreset quality, Known known) {
    const FlareImage& converged = Converged(name, request);
    ThreadPool threads(Threads());
    MeshCache cache(std::size_t{1} << 30);
    GhostCache ghosts(std::size_t{1} << 28);
    RenderContext context{threads, cache, CancelToken(), NowMs};
    if (known == Known::kGhosts) context.keeper = &ghosts;
    request.quality = quality;
    const Result<Rendering> first = Render(request, context);
    if (!first) {
        state.SkipWithError("the request was refused");
        return;
    }
    const Result<Comparison> comparison = Compare(first->image, converged);
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
    state.counters["rel_l1"] = comparison->all.rel_l1;
    state.counters["energy"] = comparison->all.energy;
    state.counters["estimated"] = first->report.facts.estimated_error.rel_l1;
    state.counters["culled"] = static_cast<double>(first->report.facts.culling.culled);
}

// A real picture, a draft of the seed lens, for the encoders.
const FlareImage& Picture() {
    static const FlareImage image = [] {
        ThreadPool threads(Threads());
        TracingMeshProvider meshes;
        FlareRequest request = SeedRequest(4.0);
        request.quality = QualityPreset::kDraft;
        return Render(request, {threads, meshes, CancelToken(), NowMs}).value().image;
    }();
    return image;
}

void CountBytes(benchmark::State& state, std::size_t bytes) {
    state.counters["bytes"] = static_cast<double>(bytes);
    state.counters["pixels"] = Rate(1920.0 * 1080.0 * static_cast<double>(state.iterations()));
}

void EncodeOurs(benchmark::State& state, ExrCompression compression, int thread_count) {
    const FlareImage& image = Picture();
    ThreadPool threads(thread_count);
    std::size_t bytes = 0;
    for (auto _ : state) {
        bytes = EncodeExr(image, {compression, ExrPixel::kHalf}, threads).bytes.size();
    }
    CountBytes(state, bytes);
}

// The same by OpenEXR's own classes, which share bands among the library's threads.
void EncodeLibrary(benchmark::State& state, ExrCompression compression, int thread_count) {
    const FlareImage& image = Picture();
    Imf::setGlobalThreadCount(thread_count > 1 ? thread_count : 0);
    std::size_t bytes = 0;
    for (auto _ : state) {
        bytes = EncodeByLibrary(image, {compression, ExrPixel::kHalf}).size();
    }
    Imf::setGlobalThreadCount(0);
    CountBytes(state, bytes);
}

void EncodeHalf(benchmark::State& state, int thread_count) {
    const FlareImage& image = Picture();
    ThreadPool threads(thread_count);
    std::size_t bytes = 0;
    for (auto _ : state) bytes = EncodeHalfPlanes(image, threads).bytes.size();
    CountBytes(state, bytes);
}

// The arranged bytes of each chunk of a ZIP file of half planes, taken out of the file again.
std::vector<std::string> ArrangedChunks(const std::string& file, const FlareImage& image) {
    std::vector<std::string> chunks;
    const std::size_t line_bytes =
        2 * image.planes.size() * static_cast<std::size_t>(image.data.width);
    // The first chunk lies behind the table, of which the last entry is 8 bytes in front of it.
    const auto count = static_cast<std::size_t>((image.data.height + 15) / 16);
    std::size_t at = 0;
    for (std::uint64_t first = 0; first != at + 8 * count; ++at) {
        std::memcpy(&first, file.data() + at + 1, 8);
    }
    at += 8 * count;
    const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> inflate(
        libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
    for (std::size_t chunk = 0; chunk < count; ++chunk) {
        std::int32_t size = 0;
        std::memcpy(&size, file.data() + at + 4, 4);
        const std::size_t lines =
            std::min<std::size_t>(16, static_cast<std::size_t>(image.data.height) - 16 * chunk);
        std::string bytes(line_bytes * lines, '\0');
        const auto packed = static_cast<std::size_t>(size);
        if (libdeflate_zlib_decompress(inflate.get(), file.data() + at + 8, packed, bytes.data(),
                                       bytes.size(), nullptr) == LIBDEFLATE_SUCCESS) {
            chunks.push_back(std::move(bytes));
        }
        at += 8 + packed;
    }
    return chunks;
}

// The last step of ZIP alone, one thread: ours (level 0 here) or a level of libdeflate.
void DeflateChunks(benchmark::State& state, int level) {
    const FlareImage& image = Picture();
    ThreadPool threads(1);
    const std::vector<std::string> chunks =
        ArrangedChunks(EncodeExr(image, {}, threads).bytes, image);
    const auto segment = static_cast<std::size_t>(image.data.width);
    std::vector<unsigned char> out(chunks.front().size() + LineDeflater::kSlack);
    const std::unique_ptr<libdeflate_compressor, void (*)(libdeflate_compressor*)> general(
        libdeflate_alloc_compressor(level), libdeflate_free_compressor);
    LineDeflater ours;
    std::size_t bytes = 0;
    for (auto _ : state) {
        bytes = 0;
        for (const std::string& chunk : chunks) {
            bytes += level == 0
                         ? ours.Deflate(reinterpret_cast<const unsigned char*>(chunk.data()),
                                        chunk.size(), segment, image.planes.size() / 2 * segment,
                                        out.data(), chunk.size())
                         : libdeflate_zlib_compress(general.get(), chunk.data(), chunk.size(),
                                                    out.data(), chunk.size());
        }
    }
    CountBytes(state, bytes);
}

// From the body of a request to the bytes of its reply, meshes in the cache.
void RequestWarm(benchmark::State& state) {
    const Result<LensLibrary> library =
        LensLibrary::Load(std::string(FLARE_SOURCE_DIR) + "/lenses");
    ThreadPool threads(Threads());
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
    flare::KeepFreedMemory();
    using benchmark::RegisterBenchmark;
    const auto milliseconds = benchmark::kMillisecond;
    RegisterBenchmark("trace/seed_lens_reference", flare::TraceSeedReference)->Unit(milliseconds);
    RegisterBenchmark("trace/seed_lens_simd", flare::TraceSeedSimd)->Unit(milliseconds);
    RegisterBenchmark("mesh/seed_lens_cold", flare::MeshCold, "tronnier-double-gauss-50mm-f2")
        ->Unit(milliseconds)
        ->UseRealTime();
    RegisterBenchmark("mesh/fisheye_cold", flare::MeshCold, "shimizu-fisheye-6mm-f2_8-220deg")
        ->Unit(milliseconds)
        ->UseRealTime();
    RegisterBenchmark("mesh/zoom_cold", flare::MeshCold, "canon-zoom-70-200mm-f2_8")
        ->Unit(milliseconds)
        ->UseRealTime();
    const auto add_render = [&](const std::string& lens, const flare::FlareRequest& request,
                                flare::QualityPreset quality) {
        const std::string preset =
            quality == flare::QualityPreset::kPreview ? "_preview" : "_final";
        const std::string name = "render/" + lens + "_1080p" + preset;
        for (const auto known : {flare::Known::kGhosts, flare::Known::kMeshes}) {
            const char* const what = known == flare::Known::kGhosts ? "_warm" : "_meshes";
            RegisterBenchmark((name + what).c_str(), flare::RenderWarm, lens, request, quality,
                              known)
                ->Unit(milliseconds)
                ->UseRealTime();
        }
    };
    for (const int f : {2, 4, 8}) {
        for (const auto quality : {flare::QualityPreset::kPreview, flare::QualityPreset::kFinal}) {
            add_render("seed_f" + std::to_string(f), flare::SeedRequest(f), quality);
        }
    }
    add_render("zoom", flare::ZoomRequest(), flare::QualityPreset::kPreview);
    for (const int n : {1, 2}) {
        const std::string threads = "/threads_" + std::to_string(n);
        const auto add = [&](const std::string& name, auto function, auto... arguments) {
            RegisterBenchmark(("encode/" + name + threads).c_str(), function, arguments..., n)
                ->Unit(milliseconds)
                ->MeasureProcessCPUTime()
                ->UseRealTime();
        };
        using flare::ExrCompression;
        add("exr_zip", flare::EncodeOurs, ExrCompression::kZip);
        add("exr_zip_library", flare::EncodeLibrary, ExrCompression::kZip);
        add("exr_none", flare::EncodeOurs, ExrCompression::kNone);
        add("exr_none_library", flare::EncodeLibrary, ExrCompression::kNone);
        add("half", flare::EncodeHalf);
    }
    RegisterBenchmark("deflate/ours", flare::DeflateChunks, 0)->Unit(milliseconds);
    for (const int level : {1, 2, 4}) {
        RegisterBenchmark(("deflate/libdeflate_" + std::to_string(level)).c_str(),
                          flare::DeflateChunks, level)
            ->Unit(milliseconds);
    }
    RegisterBenchmark("request/seed_f4_1080p_warm", flare::RequestWarm)
        ->Unit(milliseconds)
        ->UseRealTime();
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
