// SPDX-License-Identifier: Apache-2.0
//
// flare ghosts: every two-reflection ghost of a lens, brightest first.
#include <CLI/CLI.hpp>
#include <cmath>

#include "core/render/ghost_list.h"
#include "protocol/limits.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/progress.h"
#include "server/cli/table.h"
#include "server/translate/lens_json.h"

namespace flare::cli {
namespace {

struct GhostsOptions {
    std::string name;
    std::string lenses;
    double f_number = 0.0;
    bool f_number_given = false;
    double field_deg = 0.0;
    double wavelength_nm = kLineD;
    bool uncoated = false;
    bool json = false;
    int threads = ThreadsOfThisMachine();
};

// CLI::Range lets NaN through.
CLI::Validator FiniteIn(double min, double max) {
    return CLI::Validator(
        [=](const std::string& text) -> std::string {
            double value = 0.0;
            const bool inside =
                CLI::detail::lexical_cast(text, value) && value >= min && value <= max;
            return inside ? ""
                          : text + " is not a number from " + Significant(min, 6) + " to " +
                                Significant(max, 6);
        },
        "NUMBER");
}

std::string SequenceText(const std::vector<int>& sequence) {
    std::string text = "(";
    for (const int surface : sequence) {
        if (text.size() > 1) text += ',';
        text += std::to_string(surface);
    }
    text += ')';
    return text;
}

std::string GhostTable(const GhostList& list) {
    Table table({"rank", "sequence", "flux mm2", "share %", "x mm", "y mm", "peak/E0", "crossings",
                 "A", "m", "z_eff mm"});
    int rank = 0;
    for (const GhostEntry& ghost : list.ghosts) {
        const double share =
            list.total_flux_mm2 > 0.0 ? 100.0 * ghost.flux_mm2 / list.total_flux_mm2 : 0.0;
        GhostCrossing largest;
        if (!ghost.x.crossings.empty()) {
            largest = ghost.x.crossings[static_cast<std::size_t>(ghost.x.largest_crossing)];
        }
        table.AddRow({std::to_string(++rank), SequenceText(ghost.sequence),
                      Significant(ghost.flux_mm2, 5), Fixed(share, 2),
                      Fixed(ghost.centroid_mm.x, 3), Fixed(ghost.centroid_mm.y, 3),
                      Significant(ghost.peak_irradiance, 4),
                      std::to_string(ghost.x.crossings.size()), Significant(ghost.x.abcd.a, 5),
                      Significant(largest.m, 5), Significant(largest.z_eff_mm, 5)});
    }
    return table.text();
}

int Ghosts(const GhostsOptions& options) {
    const auto found = FindLens(options.name, options.lenses);
    if (!found) return Complain("", found.error());
    const std::shared_ptr<const Lens> lens = options.uncoated ? (*found)->WithBareGlass() : *found;

    GhostListOptions list_options;
    list_options.wavelength_nm = options.wavelength_nm;
    list_options.field_deg = options.field_deg;
    if (options.f_number_given) list_options.f_number = options.f_number;
    ThreadPool threads(options.threads);
    TracingMeshProvider meshes;
    std::optional<Progress> progress(std::in_place, "ranking ghosts");
    const Result<GhostList> list =
        RankGhosts(lens, list_options, {threads, meshes, CancelToken(), NowMs});
    progress.reset();
    if (!list) return Complain(options.name, list.error());
    if (options.json) return Print(GhostListJson(*lens, *list, list_options, options.uncoated));
    return Print(GhostTable(*list) + "total flux " + Significant(list->total_flux_mm2, 6) +
                 " mm2 of " + std::to_string(list->ghosts.size()) + " ghosts\n");
}

}  // namespace

void AddGhostsCommand(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<GhostsOptions>();
    CLI::App* command = app.add_subcommand(
        "ghosts", "Rank the ghosts of a lens for a distant light of irradiance 1");
    command->add_option("name", options->name, "A lens of the library or a lens file")
        ->required()
        ->type_name("NAME");
    CLI::Option* f_number =
        command->add_option("--f-number", options->f_number, "Iris; without it: wide open")
            ->check(FiniteIn(limits::kMinFNumber, limits::kMaxFNumber));
    command
        ->add_option("--field-deg", options->field_deg, "Angle of the light to the axis, degrees")
        ->check(FiniteIn(-180.0, 180.0));
    command->add_option("--wavelength-nm", options->wavelength_nm, "Wavelength in air, nm")
        ->check(FiniteIn(limits::kMinWavelength_nm, limits::kMaxWavelength_nm))
        ->capture_default_str();
    command->add_flag("--uncoated", options->uncoated, "Bare glass whatever the lens file says");
    command->add_flag("--json", options->json, "JSON instead of a table");
    command->add_option("--lenses", options->lenses, "The folder of lens files")->type_name("DIR");
    command->add_option("--threads", options->threads, "Threads to work with")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command->callback([options, f_number, &exit_code] {
        options->f_number_given = f_number->count() > 0;
        exit_code = Ghosts(*options);
    });
}

}  // namespace flare::cli
