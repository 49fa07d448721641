// SPDX-License-Identifier: Apache-2.0
//
// flare tradeoff: what every setting costs in error and buys in time, on this machine.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <ctime>

#include "core/optics/lens_coatings.h"
#include "protocol/limits.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/options.h"
#include "server/cli/progress.h"
#include "server/tradeoff/page.h"
#include "server/tradeoff/sweep.h"

namespace flare::cli {
namespace {

struct TradeoffOptions {
    std::vector<std::string> lenses;
    std::string folder, library, coatings = "own";
    std::string size = "480x270";
    std::vector<double> f_numbers{2.0, 5.6, 16.0}, field_deg;
    std::vector<std::string> knobs;
    int runs = 3;
    int threads = ThreadsOfThisMachine();
};

// Processor time of this program, all threads.
double CpuMs() {
    return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

volatile std::sig_atomic_t interrupted = 0;

// Ctrl-C ends the sweep after the picture in work is given up; a second one ends the program.
class InterruptWatch {
  public:
    InterruptWatch() {
        struct sigaction watch {};
        watch.sa_handler = [](int) { interrupted = 1; };
        watch.sa_flags = static_cast<int>(SA_RESETHAND);
        sigaction(SIGINT, &watch, nullptr);
        sigaction(SIGTERM, &watch, nullptr);
    }
    static CancelToken Token() {
        return CancelToken().OrWhen([] { return interrupted != 0; });
    }
};

Result<TradeoffScene> BaseScene(const TradeoffOptions& options, const std::string& name) {
    const Result<std::shared_ptr<const Lens>> lens = FindLens(name, options.library);
    if (!lens) return lens.error();
    TradeoffScene scene;
    scene.lens_name = name;
    scene.lens = *lens;
    scene.coatings = options.coatings;
    if (options.coatings != "own") {
        CoatingOverride coatings;
        coatings.default_coating = options.coatings;
        const Result<std::shared_ptr<const Lens>> coated = (*lens)->WithCoatings(coatings);
        if (!coated) return coated.error();
        scene.lens = *coated;
    }
    if (std::sscanf(options.size.c_str(), "%dx%d", &scene.width, &scene.height) != 2 ||
        scene.width < 1 || scene.height < 1 || scene.width > kMaxImageSide ||
        scene.height > kMaxImageSide) {
        return Error{"bad_value", "--size " + options.size + " is not as 480x270", ""};
    }
    return scene;
}

std::optional<Error> WriteReports(const SweepPlan& plan, const SweepOutcome& outcome) {
    const std::vector<NamedSvg> charts = TradeoffCharts(outcome.rows, plan.trials);
    for (const NamedSvg& chart : charts) {
        if (auto error = WriteWhole(plan.folder + "/" + chart.file, chart.svg)) return error;
    }
    return WriteWhole(plan.folder + "/index.html", TradeoffPage(outcome.rows, plan.trials, charts));
}

int Tradeoff(const TradeoffOptions& options) {
    SweepPlan plan;
    plan.folder = options.folder;
    plan.runs = options.runs;
    Result<std::vector<Trial>> trials = TrialsOf(options.knobs);
    if (!trials) return Complain("", trials.error());
    plan.trials = std::move(*trials);
    for (const std::string& name : options.lenses) {
        const Result<TradeoffScene> base = BaseScene(options, name);
        if (!base) return Complain(name, base.error());
        for (TradeoffScene& scene : ScenesOf(*base, options.f_numbers, options.field_deg)) {
            plan.scenes.push_back(std::move(scene));
        }
    }
    const InterruptWatch watch;
    ThreadPool threads(options.threads);
    std::optional<ProgressBar> bar(std::in_place);
    const Result<SweepOutcome> outcome = RunSweep(
        plan, {threads, InterruptWatch::Token(), NowMs, CpuMs,
               [&](int done, int all, const std::string& what) { bar->Show(done, all, what); }});
    bar.reset();
    if (!outcome) {
        Complain("", outcome.error());
        return outcome.error().code == "io" ? kFailed : kBadInput;
    }
    if (const auto error = WriteReports(plan, *outcome)) {
        Complain("", *error);
        return kFailed;
    }
    const auto rows = static_cast<int>(outcome->rows.size());
    std::fprintf(stderr, "flare: %d of %d rows are there, %d of them new; %s/index.html\n", rows,
                 outcome->wanted, outcome->measured, plan.folder.c_str());
    if (rows == outcome->wanted) return kDone;
    std::fputs("flare: interrupted; the same command goes on\n", stderr);
    return kFailed;
}

std::string KnobList() {
    std::string list;
    for (const std::string& knob : KnobNames()) list += (list.empty() ? "" : ", ") + knob;
    return list;
}

}  // namespace

void AddTradeoffCommand(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<TradeoffOptions>();
    CLI::App* command = app.add_subcommand(
        "tradeoff", "Measure error against time over all settings: CSV, SVG and an HTML page");
    command->add_option("lenses", options->lenses, "Lenses, by name or path")
        ->required()
        ->type_name("NAME");
    command
        ->add_option("-o,--output", options->folder,
                     "The folder for results; what it holds already is not measured again")
        ->required()
        ->type_name("DIR");
    command->add_option("--size", options->size, "Of the pictures, pixels")
        ->type_name("WxH")
        ->capture_default_str();
    command->add_option("--f-numbers", options->f_numbers, "Openings, or the lens's widest")
        ->delimiter(',')
        ->check(FiniteIn(limits::kMinFNumber, limits::kMaxFNumber))
        ->capture_default_str();
    command
        ->add_option("--angles", options->field_deg,
                     "Field angles of the light, degrees; without them 0.2, 0.6 and 1 of the angle "
                     "of the frame's edge")
        ->delimiter(',')
        ->check(FiniteIn(0.0, 180.0));
    command
        ->add_option("--knobs", options->knobs,
                     "Only these, or KNOB=VALUE for one value, of: " + KnobList())
        ->delimiter(',')
        ->type_name("KNOB");
    command
        ->add_option("--coatings", options->coatings,
                     "A coating for every surface, or own: those of the lens file")
        ->capture_default_str();
    command->add_option("--runs", options->runs, "Timed runs with meshes at hand, at most")
        ->check(CLI::Range(1, 100))
        ->capture_default_str();
    command->add_option("--threads", options->threads, "Threads to render with")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    AddLensFolder(*command, options->library);
    command->callback([options, &exit_code] { exit_code = Tradeoff(*options); });
}

}  // namespace flare::cli
