// SPDX-License-Identifier: Apache-2.0
//
// flare lens: the lens library. Its subcommands stand in files of their own.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "server/cli/app.h"
#include "server/cli/lens_commands.h"

namespace flare::cli {

void AddLensCommands(CLI::App& app, int& exit_code) {
    CLI::App* lens = app.add_subcommand("lens", "The lens library");
    lens->require_subcommand(0, 1);
    lens->callback([lens, &exit_code] {
        if (!lens->get_subcommands().empty()) return;
        std::fputs(lens->help().c_str(), stderr);
        exit_code = kBadInput;
    });
    AddLensList(*lens, exit_code);
    AddLensShow(*lens, exit_code);
    AddLensCheck(*lens, exit_code);
    AddLensImport(*lens, exit_code);
    AddLensDraw(*lens, exit_code);
}

}  // namespace flare::cli
