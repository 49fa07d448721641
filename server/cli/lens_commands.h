// SPDX-License-Identifier: Apache-2.0
//
// The subcommands of `flare lens`, each in its own file.
#pragma once

namespace CLI {
class App;
}

namespace flare::cli {

void AddLensList(CLI::App& lens, int& exit_code);
void AddLensShow(CLI::App& lens, int& exit_code);
void AddLensCheck(CLI::App& lens, int& exit_code);
void AddLensImport(CLI::App& lens, int& exit_code);
void AddLensDraw(CLI::App& lens, int& exit_code);

}  // namespace flare::cli
