// SPDX-License-Identifier: Apache-2.0
#include "server/cli/options.h"

#include <cmath>

#include "protocol/limits.h"
#include "server/cli/table.h"

namespace flare::cli {
namespace {

template <class Holds>
CLI::Validator Numbers(Holds holds, const std::string& expected) {
    return CLI::Validator(
        [=](const std::string& text) -> std::string {
            double value = 0.0;
            const bool good = CLI::detail::lexical_cast(text, value) && holds(value);
            return good ? "" : text + " is not a number " + expected;
        },
        "NUMBER");
}

}  // namespace

CLI::Validator FiniteIn(double min, double max) {
    return Numbers([=](double value) { return value >= min && value <= max; },
                   "from " + Significant(min, 6) + " to " + Significant(max, 6));
}

CLI::Validator AboveZeroUpTo(double max) {
    return Numbers([=](double value) { return value > 0.0 && value <= max; },
                   "above 0 and at most " + Significant(max, 6));
}

void AddLensName(CLI::App& command, std::string& name) {
    command.add_option("name", name, "A lens of the library or a lens file")
        ->required()
        ->type_name("NAME");
}

void AddLensFolder(CLI::App& command, std::string& folder) {
    command.add_option("--lenses", folder, "The folder of lens files")->type_name("DIR");
}

void AddStateOptions(CLI::App& command, LensState& state) {
    command
        .add_option("--focus-m", state.focus_m,
                    "Focus distance from the sensor, m; without it: infinity")
        ->check(AboveZeroUpTo(limits::kMaxDistance_m));
    command
        .add_option("--zoom-mm", state.zoom_mm,
                    "Focal length of a zoom, mm; without it: as the lens file begins")
        ->check(AboveZeroUpTo(limits::kMaxZoom_mm));
}

std::string StateText(const LensInState& lens) {
    const auto number = [](double value, const char* unit) {
        return std::isinf(value) ? "infinity" : Significant(value, 6) + unit;
    };
    std::string text;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    if (lens.state.focus_m) add("focus " + number(*lens.state.focus_m, " m"));
    if (lens.state.zoom_mm) add("zoom " + number(*lens.state.zoom_mm, " mm"));
    for (const StateClamp& clamp : lens.clamped) {
        add(clamp.field + " clamped from " + number(clamp.from, "") + " to " +
            number(clamp.to, ""));
    }
    return text;
}

}  // namespace flare::cli
