// SPDX-License-Identifier: Apache-2.0
//
// flare ghosts: the ghosts of a lens, brightest first.
#include <CLI/CLI.hpp>

#include "protocol/limits.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/options.h"
#include "server/cli/progress.h"
#include "server/cli/table.h"
#include "server/translate/ghost_query.h"

namespace flare::cli {
namespace {

struct GhostsOptions {
    std::string name;
    std::string lenses;
    GhostQuery query;
    std::string coatings;
    bool json = false;
    int threads = ThreadsOfThisMachine();
};

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

// What the table cannot show, in lines below it.
std::string Totals(const RankedGhosts& ghosts) {
    std::string text = "total flux " + Significant(ghosts.list.total_flux_mm2, 6) + " mm2 of " +
                       std::to_string(ghosts.list.ghosts.size()) + " ghosts\n";
    if (const auto& four = ghosts.list.four_reflections) {
        text += "of four reflections: " + std::to_string(four->rendered) + " of " +
                std::to_string(four->sequences) + " sequences reach the peak " +
                Significant(four->threshold, 4) + ", " + Significant(four->rendered_flux_mm2, 4) +
                " mm2; the others hold " + Significant(four->lost_flux_mm2, 4) + " mm2\n";
    }
    const std::string state = StateText(ghosts.lens);
    return text + (state.empty() ? "" : state + "\n");
}

int Ghosts(const GhostsOptions& options) {
    const auto lens = FindLens(options.name, options.lenses);
    if (!lens) return Complain("", lens.error());
    ThreadPool threads(options.threads);
    TracingMeshProvider meshes;
    std::optional<Progress> progress(std::in_place, "ranking ghosts");
    const Result<RankedGhosts> ghosts =
        RankGhostsFor(*lens, options.query, {threads, meshes, CancelToken(), NowMs});
    progress.reset();
    if (!ghosts) return Complain(options.name, ghosts.error());
    if (options.json) return Print(GhostListJson(*ghosts, options.query));
    return Print(GhostTable(ghosts->list) + Totals(*ghosts));
}

void AddLightOptions(CLI::App& command, GhostQuery& query) {
    command.add_option("--f-number", query.f_number, "Iris; without it: wide open")
        ->check(FiniteIn(limits::kMinFNumber, limits::kMaxFNumber));
    command.add_option("--field-deg", query.field_deg, "Angle of the light to the axis, degrees")
        ->check(FiniteIn(-180.0, 180.0));
    command
        .add_option("--azimuth-deg", query.azimuth_deg,
                    "Its direction around the axis, degrees; 0 is in the x-z plane, 90 in y-z")
        ->check(FiniteIn(-360.0, 360.0));
    command.add_option("--wavelength-nm", query.wavelength_nm, "Wavelength in air, nm")
        ->check(FiniteIn(limits::kMinWavelength_nm, limits::kMaxWavelength_nm))
        ->default_str("587.5618");
}

void AddModelOptions(CLI::App& command, GhostsOptions& options) {
    ModelSpec& model = options.query.model;
    command.add_option("--reflections", model.reflections, "2, or 4: those of four as well")
        ->check(CLI::IsMember({2, 4}))
        ->capture_default_str();
    command
        .add_option("--threshold", model.four_reflection_threshold,
                    "Smallest peak irradiance of a ghost of four reflections that is listed")
        ->check(AboveZeroUpTo(limits::kMaxFourReflectionThreshold))
        ->capture_default_str();
    command.add_flag("--sensor-reflection", model.sensor_reflection,
                     "Ghosts that the sensor reflects as well");
    CLI::Option* uncoated = command.add_flag("--uncoated", options.query.coatings.none,
                                             "Bare glass whatever the lens file says");
    command
        .add_option("--coatings", options.coatings,
                    "A coating on every surface between air and glass; none: bare glass")
        ->type_name("NAME")
        ->excludes(uncoated);
}

}  // namespace

void AddGhostsCommand(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<GhostsOptions>();
    CLI::App* command = app.add_subcommand(
        "ghosts", "Rank the ghosts of a lens for a distant light of irradiance 1");
    AddLensName(*command, options->name);
    AddStateOptions(*command, options->query.state);
    AddLightOptions(*command, options->query);
    AddModelOptions(*command, *options);
    command->add_flag("--json", options->json, "JSON instead of a table");
    AddLensFolder(*command, options->lenses);
    command->add_option("--threads", options->threads, "Threads to work with")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    command->callback([options, &exit_code] {
        wire::Coatings& coatings = options->query.coatings;
        if (options->coatings == "none") {
            coatings.none = true;
        } else if (!options->coatings.empty()) {
            coatings.default_name = options->coatings;
        }
        exit_code = Ghosts(*options);
    });
}

}  // namespace flare::cli
