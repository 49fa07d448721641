// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/sweep.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "core/image/channel_name.h"
#include "core/image/exr.h"
#include "core/render/compare.h"
#include "core/render/renderer.h"
#include "server/cache/mesh_cache.h"

namespace flare {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMeshBytes = std::size_t{2} << 30;
constexpr double kEnough_ms = 1500.0;  // of runs of one picture

Error IoError(const std::string& path, const std::string& what) {
    return {"io", path + ": " + what, ""};
}

Result<std::string> ReadWhole(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) return IoError(path, "cannot be read");
    return std::string(std::istreambuf_iterator<char>(file), {});
}

// What a sweep changes is in this layer; the root holds the same numbers again.
FlareImage GhostsOf(FlareImage image) {
    std::erase_if(image.planes,
                  [](const ImagePlane& plane) { return LayerOfChannel(plane.name) != "ghosts"; });
    return image;
}

double Median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

class Sweep {
  public:
    Sweep(const SweepPlan& plan, const SweepTools& tools) : plan_(plan), tools_(tools) {
        outcome_.wanted = static_cast<int>(plan.scenes.size() * plan.trials.size());
    }

    Result<SweepOutcome> Run() {
        if (std::optional<Error> error = Open()) return *error;
        for (const TradeoffScene& scene : plan_.scenes) {
            references_.clear();
            for (const Trial& trial : plan_.trials) {
                TradeoffRow row = RowFor(scene, trial);
                const auto known = known_.find(row.Key());
                if (known != known_.end()) {
                    outcome_.rows.push_back(known->second);
                    continue;
                }
                if (tools_.cancel.cancelled()) continue;
                std::optional<Error> error = Measure(scene, trial, row);
                if (tools_.cancel.cancelled()) continue;
                if (!error) error = Keep(row);
                if (error) return *error;
            }
        }
        return std::move(outcome_);
    }

  private:
    // The folder, and what its table holds. A line that was cut short goes.
    std::optional<Error> Open() {
        std::error_code failed;
        fs::create_directories(fs::path(plan_.folder) / "reference", failed);
        if (failed) return IoError(plan_.folder, failed.message());
        table_ = (fs::path(plan_.folder) / "tradeoff.csv").string();
        std::string kept = CsvHead();
        if (fs::exists(table_)) {
            const Result<std::string> text = ReadWhole(table_);
            if (!text) return text.error();
            const Result<std::vector<TradeoffRow>> rows = RowsFromCsv(*text);
            if (!rows) {
                return Error{rows.error().code, table_ + ": " + rows.error().message,
                             rows.error().where};
            }
            for (const TradeoffRow& row : *rows) known_[row.Key()] = row;
            kept = text->substr(0, text->rfind('\n') + 1);
            if (kept.size() == text->size()) return std::nullopt;
        }
        return WriteWhole(table_, kept);
    }

    std::optional<Error> Keep(const TradeoffRow& row) {
        std::ofstream file(table_, std::ios::binary | std::ios::app);
        file << CsvLine(row) << std::flush;
        if (!file) return IoError(table_, "cannot be written");
        known_[row.Key()] = row;
        outcome_.rows.push_back(row);
        ++outcome_.measured;
        return std::nullopt;
    }

    void Say(const std::string& what) const {
        tools_.progress(static_cast<int>(outcome_.rows.size()), outcome_.wanted, what);
    }

    Result<const FlareImage*> Reference(const TradeoffScene& scene, Truth truth) {
        const auto at_hand = references_.find(truth);
        if (at_hand != references_.end()) return &at_hand->second;
        const std::string path =
            (fs::path(plan_.folder) / "reference" / (scene.Key(truth).hex() + ".exr")).string();
        if (fs::exists(path)) {
            const Result<std::string> bytes = ReadWhole(path);
            if (!bytes) return bytes.error();
            Result<FlareImage> image = DecodeExr(*bytes);
            if (!image) return Error{image.error().code, path + ": " + image.error().message, ""};
            return &(references_[truth] = std::move(*image));
        }
        Say(scene.name() + ": reference picture");
        FlareRequest request = scene.Request();
        ApplyTruth(truth, request);
        TracingMeshProvider meshes;
        Result<Rendering> rendering =
            Render(request, {tools_.threads, meshes, tools_.cancel, tools_.now_ms});
        if (!rendering) return rendering.error();
        const FlareImage image = GhostsOf(std::move(rendering->image));
        const ExrOptions options{ExrCompression::kZip, ExrPixel::kFloat};
        const std::string bytes = EncodeExr(image, options, tools_.threads).bytes;
        if (std::optional<Error> error = WriteWhole(path, bytes)) return *error;
        // As it will be read next time, so that sums are made in the same order.
        return &(references_[truth] = DecodeExr(bytes).value());
    }

    std::optional<Error> Measure(const TradeoffScene& scene, const Trial& trial, TradeoffRow& row) {
        const Result<const FlareImage*> reference = Reference(scene, trial.truth);
        if (!reference) return reference.error();
        Say(scene.name() + ": " + trial.name());
        FlareRequest request = scene.Request();
        Apply(trial, request);
        MeshCache meshes(kMeshBytes);
        const RenderContext context{tools_.threads, meshes, tools_.cancel, tools_.now_ms};

        const double began_ms = tools_.now_ms(), cpu_ms = tools_.cpu_ms();
        Result<Rendering> rendering = Render(request, context);
        if (!rendering) return rendering.error();
        row.cold_ms = row.warm_ms = tools_.now_ms() - began_ms;
        row.cold_cpu_ms = row.warm_cpu_ms = tools_.cpu_ms() - cpu_ms;
        row.runs = 1;
        row.threads = tools_.threads.threads();
        const Report& report = rendering->report;
        row.rays =
            static_cast<double>(trial.photon ? report.facts.photon->rays : report.work.rays_traced);
        row.pieces = static_cast<double>(report.work.polygons);
        row.estimated = report.facts.estimated_error.rel_l1;

        const Result<Comparison> compared =
            Compare(GhostsOf(std::move(rendering->image)), **reference);
        if (!compared) return compared.error();
        const ErrorMetrics& metrics = compared->all;
        row.rel_l1 = metrics.rel_l1;
        row.energy = metrics.energy;
        row.rel_l2_blur2 = metrics.rel_l2_blur2;
        row.stops_mean = metrics.log_error_stops_mean;
        row.stops_p99 = metrics.log_error_stops_p99;
        row.p999_ratio = metrics.p999_ratio;
        return trial.photon ? std::nullopt : TimeWarm(request, context, row);
    }

    std::optional<Error> TimeWarm(const FlareRequest& request, const RenderContext& context,
                                  TradeoffRow& row) const {
        std::vector<double> took_ms, took_cpu_ms;
        double all_ms = 0.0;
        while (static_cast<int>(took_ms.size()) < plan_.runs &&
               (took_ms.empty() || all_ms < kEnough_ms)) {
            const double began_ms = tools_.now_ms(), cpu_ms = tools_.cpu_ms();
            const Result<Rendering> again = Render(request, context);
            if (!again) return again.error();
            took_ms.push_back(tools_.now_ms() - began_ms);
            took_cpu_ms.push_back(tools_.cpu_ms() - cpu_ms);
            all_ms += took_ms.back();
        }
        row.runs = static_cast<int>(took_ms.size());
        row.warm_ms = Median(std::move(took_ms));
        row.warm_cpu_ms = Median(std::move(took_cpu_ms));
        return std::nullopt;
    }

    const SweepPlan& plan_;
    const SweepTools& tools_;
    std::string table_;
    std::map<std::string, TradeoffRow> known_;
    std::map<Truth, FlareImage> references_;  // of the scene in work
    SweepOutcome outcome_;
};

}  // namespace

std::optional<Error> WriteWhole(const std::string& path, const std::string& bytes) {
    const std::string beside = path + ".part";
    {
        std::ofstream file(beside, std::ios::binary | std::ios::trunc);
        file << bytes << std::flush;
        if (!file) return IoError(beside, "cannot be written");
    }
    std::error_code failed;
    fs::rename(beside, path, failed);
    if (failed) return IoError(path, failed.message());
    return std::nullopt;
}

Result<SweepOutcome> RunSweep(const SweepPlan& plan, const SweepTools& tools) {
    return Sweep(plan, tools).Run();
}

}  // namespace flare
