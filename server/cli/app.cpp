// SPDX-License-Identifier: Apache-2.0
#include "server/cli/app.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

namespace flare::cli {

int Run(int argc, const char* const* argv) {
    CLI::App app("Lens flares from lens prescriptions.", "flare");
    app.set_version_flag("--version", "flare " FLARE_VERSION);
    app.require_subcommand(0, 1);  // none is answered below, after an unknown word has been
    app.footer(
        "A lens NAME may be a path to a lens file.\n"
        "Exit codes: 0 done; 2 bad usage or bad input; 3 the server cannot be reached or refused;\n"
        "1 anything else.");
    int exit_code = kDone;
    AddRenderCommand(app, exit_code);
    AddLensCommands(app, exit_code);
    AddGlassCommands(app, exit_code);
    AddGhostsCommand(app, exit_code);
    AddTraceCommand(app, exit_code);
    AddEncoderCommands(app, exit_code);
    AddCompareCommand(app, exit_code);
    AddTradeoffCommand(app, exit_code);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        app.exit(error);
        return kBadInput;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "flare: %s\n", error.what());
        return kFailed;
    }
    if (app.get_subcommands().empty()) {
        std::fputs(app.help().c_str(), stderr);
        return kBadInput;
    }
    return exit_code;
}

}  // namespace flare::cli
