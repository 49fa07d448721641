// SPDX-License-Identifier: Apache-2.0
//
// flare lens list: what is in the library.
#include <CLI/CLI.hpp>

#include "server/cli/files.h"
#include "server/cli/lens_commands.h"
#include "server/cli/options.h"
#include "server/cli/table.h"
#include "server/translate/lens_json.h"

namespace flare::cli {
namespace {

struct ListOptions {
    std::string lenses;
    bool json = false;
};

int List(const ListOptions& options) {
    const Result<LensLibrary> library = OpenLibrary(options.lenses);
    if (!library) return Complain("", library.error());
    if (options.json) return Print(LensListJson(*library));
    Table table({"name", "EFL mm", "zoom mm", "f/", "squeeze", "surfaces", "maker"});
    for (const std::string& name : library->Names()) {
        const auto lens = library->Find(name);
        if (!lens) continue;
        const Prescription& file = (*lens)->prescription();
        const std::vector<double>& zoom = file.states.focal_mm;
        table.AddRow(
            {name, Fixed((*lens)->first_order(file.design_section).efl_mm, 3),
             zoom.empty() ? "" : Significant(zoom.front(), 5) + "-" + Significant(zoom.back(), 5),
             Fixed((*lens)->f_number(), 2),
             (*lens)->rotational() ? "" : Fixed((*lens)->squeeze(), 3),
             std::to_string((*lens)->surfaces().size()), file.maker});
    }
    for (const auto& [name, error] : library->broken()) Complain(name + ".toml", error);
    return Print(table.text());
}

}  // namespace

void AddLensList(CLI::App& lens, int& exit_code) {
    auto options = std::make_shared<ListOptions>();
    CLI::App* command = lens.add_subcommand("list", "List the lenses of the library");
    command->add_flag("--json", options->json, "JSON instead of a table");
    AddLensFolder(*command, options->lenses);
    command->callback([options, &exit_code] { exit_code = List(*options); });
}

}  // namespace flare::cli
