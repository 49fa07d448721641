// SPDX-License-Identifier: Apache-2.0
//
// flare lens draw: a lens in cross-section with its rays and the paths of ghosts, as SVG.
#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>

#include "core/drawing/lens_drawing.h"
#include "core/optics/paraxial.h"
#include "protocol/limits.h"
#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/cli/lens_commands.h"
#include "server/cli/options.h"
#include "server/cli/table.h"

namespace flare::cli {
namespace {

struct DrawOptions {
    std::string name;
    std::string lenses;
    std::string output;
    std::vector<std::string> ghosts;
    std::optional<double> field_deg, f_number;
    LensState state;
};

// "9,1"; brackets and spaces around numbers, as listings have them, are fine.
Result<BounceSequence> SequenceFromText(const std::string& text) {
    const Error unreadable{"bad_value",
                           "\"" + text + "\" is not a sequence of surfaces such as 9,1", "--ghost"};
    std::string_view rest = text;
    const auto skip_spaces = [&rest] {
        while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    };
    if (rest.size() > 1 && rest.front() == '(' && rest.back() == ')') {
        rest = rest.substr(1, rest.size() - 2);
    }
    BounceSequence sequence;
    while (true) {
        skip_spaces();
        int surface = 0;
        const auto [end, fault] = std::from_chars(rest.data(), rest.data() + rest.size(), surface);
        if (fault != std::errc()) return unreadable;
        rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
        sequence.push_back(surface);
        if (sequence.size() > limits::kBounces) {
            return Error{
                "limit",
                "a sequence has at most " + std::to_string(limits::kBounces) + " reflections",
                "--ghost"};
        }
        skip_spaces();
        if (rest.empty()) return sequence;
        if (rest.front() != ',') return unreadable;
        rest.remove_prefix(1);
    }
}

void SayClamped(const std::string& name, const std::string& what, double from, double to) {
    std::fprintf(stderr, "flare: %s: %s clamped: %s -> %s\n", name.c_str(), what.c_str(),
                 Significant(from, 6).c_str(), Significant(to, 6).c_str());
}

Result<DrawingOptions> DrawingFrom(const DrawOptions& options) {
    DrawingOptions drawing;
    drawing.field_deg = options.field_deg;
    drawing.f_number = options.f_number;
    for (const std::string& text : options.ghosts) {
        const Result<BounceSequence> sequence = SequenceFromText(text);
        if (!sequence) return sequence.error();
        drawing.ghosts.push_back(*sequence);
    }
    return drawing;
}

int Draw(const DrawOptions& options) {
    Result<DrawingOptions> drawing = DrawingFrom(options);
    if (!drawing) return Complain("", drawing.error());
    const auto base = FindLens(options.name, options.lenses);
    if (!base) return Complain("", base.error());
    const Result<LensInState> set = SetState(*base, options.state);
    if (!set) return Complain(options.name, set.error());
    drawing->state = set->state;
    const Result<std::string> svg = DrawLens(*set->lens, *drawing);
    if (!svg) return Complain(options.name, svg.error());

    for (const StateClamp& clamp : set->clamped) {
        SayClamped(options.name, clamp.field, clamp.from, clamp.to);
    }
    if (options.f_number) {
        const StopSetting stop = StopForFNumber(*set->lens, *options.f_number);
        if (stop.clamped) SayClamped(options.name, "f_number", *options.f_number, stop.f_number);
    }
    if (const std::optional<Error> error = WriteOutput(options.output, *svg)) {
        return Complain("", *error);
    }
    return kDone;
}

}  // namespace

void AddLensDraw(CLI::App& lens, int& exit_code) {
    auto options = std::make_shared<DrawOptions>();
    CLI::App* draw =
        lens.add_subcommand("draw", "Draw a lens to scale with its rays and ghosts' paths, as SVG");
    AddLensName(*draw, options->name);
    draw->add_option("-o,--output", options->output, "The SVG file, or - for standard output")
        ->required()
        ->type_name("FILE");
    draw->add_option("--ghost", options->ghosts,
                     "A ghost by the surfaces that reflect: 9,1. Up to " +
                         std::to_string(kMostDrawnGhosts) + " times")
        ->type_name("R1,R2")
        ->allow_extra_args(false);
    draw->add_option("--field-deg", options->field_deg,
                     "Angle of the light above the axis, degrees; without it the field beam goes "
                     "to 0.7 of the image circle and ghosts are those of a light on the axis")
        ->check(FiniteIn(-180.0, 180.0));
    draw->add_option("--f-number", options->f_number, "Iris; without it: wide open")
        ->check(FiniteIn(limits::kMinFNumber, limits::kMaxFNumber));
    AddStateOptions(*draw, options->state);
    AddLensFolder(*draw, options->lenses);
    draw->callback([options, &exit_code] { exit_code = Draw(*options); });
}

}  // namespace flare::cli
