// SPDX-License-Identifier: Apache-2.0
//
// flare compare: how far one picture is from another, the second being the reference.
#include <CLI/CLI.hpp>

#include "core/image/exr.h"
#include "core/render/compare.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/progress.h"
#include "server/cli/table.h"
#include "server/translate/compare_json.h"

namespace flare::cli {
namespace {

struct CompareOptions {
    std::string image, reference;
    bool json = false;
};

Result<FlareImage> ReadExr(const std::string& path) {
    const Result<std::string> bytes = ReadInput(path);
    if (!bytes) return bytes.error();
    Result<FlareImage> image = DecodeExr(*bytes);
    if (!image) return Error{image.error().code, path + ": " + image.error().message, ""};
    return image;
}

void AddMetrics(Table& table, const std::string& layer, const ErrorMetrics& metrics) {
    table.AddRow({layer, Significant(metrics.rel_l1, 5), Significant(metrics.energy, 5),
                  Significant(metrics.rel_l2_blur2, 5),
                  Significant(metrics.log_error_stops_mean, 4),
                  Significant(metrics.log_error_stops_p99, 4), Significant(metrics.p999_ratio, 6),
                  Significant(metrics.max_abs, 5)});
}

int CompareFiles(const CompareOptions& options) {
    const Result<FlareImage> image = ReadExr(options.image);
    if (!image) return Complain("", image.error());
    const Result<FlareImage> reference = ReadExr(options.reference);
    if (!reference) return Complain("", reference.error());
    std::optional<Progress> progress(std::in_place, "comparing");
    const Result<Comparison> comparison = Compare(*image, *reference);
    progress.reset();
    if (!comparison) return Complain(options.image, comparison.error());
    if (options.json) return Print(ComparisonJson(*comparison));

    Table table({"layer", "rel_l1", "energy", "rel_l2_blur2", "log stops mean", "log stops p99",
                 "p999 ratio", "max abs"});
    AddMetrics(table, "all", comparison->all);
    for (const LayerComparison& layer : comparison->layers) {
        AddMetrics(table, layer.layer.empty() ? "(root)" : layer.layer, layer.metrics);
    }
    return Print(table.text());
}

}  // namespace

void AddCompareCommand(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<CompareOptions>();
    CLI::App* command = app.add_subcommand("compare", "Measure how far a picture is from another");
    command->add_option("image", options->image, "The picture")->required()->type_name("A.exr");
    command->add_option("reference", options->reference, "The picture to measure it against")
        ->required()
        ->type_name("B.exr");
    command->add_flag("--json", options->json, "JSON instead of a table");
    command->callback([options, &exit_code] { exit_code = CompareFiles(*options); });
}

}  // namespace flare::cli
