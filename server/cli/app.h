// SPDX-License-Identifier: Apache-2.0
//
// The command line tool. Each group of subcommands stands in its own file and adds itself to the
// parser; a subcommand that ran has put its exit code into `exit_code`.
#pragma once

namespace CLI {
class App;
}

namespace flare::cli {

enum ExitCode : int {
    kDone = 0,
    kFailed = 1,       // anything that is not below: no space left, a bug
    kBadInput = 2,     // bad usage or bad input
    kServerFailed = 3  // the server cannot be reached or refused
};

// Parses the arguments, runs the subcommand and returns the program's exit code.
int Run(int argc, const char* const* argv);

void AddRenderCommand(CLI::App& app, int& exit_code);
void AddLensCommands(CLI::App& app, int& exit_code);
void AddGlassCommands(CLI::App& app, int& exit_code);
void AddGhostsCommand(CLI::App& app, int& exit_code);
void AddTraceCommand(CLI::App& app, int& exit_code);
void AddEncoderCommands(CLI::App& app, int& exit_code);
void AddCompareCommand(CLI::App& app, int& exit_code);
void AddTradeoffCommand(CLI::App& app, int& exit_code);

}  // namespace flare::cli
