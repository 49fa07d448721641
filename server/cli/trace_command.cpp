// SPDX-License-Identifier: Apache-2.0
//
// flare trace: exact rays through one bounce sequence, for checking against other tools.
#include <CLI/CLI.hpp>

#include "server/cli/app.h"
#include "server/cli/files.h"
#include "server/translate/trace_from_wire.h"

namespace flare::cli {
namespace {

int Trace(const std::string& lenses) {
    const Result<LensLibrary> library = OpenLibrary(lenses);
    if (!library) return Complain("", library.error());
    const Result<std::string> input = ReadInput("-");
    if (!input) return Complain("", input.error());
    const Result<std::string> output = TraceJson(*input, *library);
    if (!output) return Complain("standard input", output.error());
    return Print(*output);
}

}  // namespace

void AddTraceCommand(CLI::App& app, int& exit_code) {
    auto lenses = std::make_shared<std::string>();
    CLI::App* command = app.add_subcommand(
        "trace", "Trace exact rays: JSON on standard input, JSON on standard output");
    command->add_option("--lenses", *lenses, "The folder of lens files")->type_name("DIR");
    command->footer(
        "Input: {\"lens\": NAME, \"wavelength_nm\": 587.5618, \"sequence\": [9, 1], \"clip\": "
        "true,\n"
        "        \"rays\": [{\"origin\": [x, y, z], \"direction\": [dx, dy, dz]}]}\n"
        "in lens space, mm; \"prescription\", \"coatings\", \"f_number\", \"focus_m\" and "
        "\"zoom_mm\" as in a\nrequest.");
    command->callback([lenses, &exit_code] { exit_code = Trace(*lenses); });
}

}  // namespace flare::cli
