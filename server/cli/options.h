// SPDX-License-Identifier: Apache-2.0
//
// Options that several subcommands have, and the checks of their values.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "core/optics/lens_state.h"

namespace flare::cli {

// CLI::Range lets NaN through.
CLI::Validator FiniteIn(double min, double max);
CLI::Validator AboveZeroUpTo(double max);

// The positional NAME and --lenses DIR.
void AddLensName(CLI::App& command, std::string& name);
void AddLensFolder(CLI::App& command, std::string& folder);

// --focus-m and --zoom-mm.
void AddStateOptions(CLI::App& command, LensState& state);

// "focus 1.5 m, zoom 135 mm", and what was clamped; "" for a lens without zoom at infinity.
std::string StateText(const LensInState& lens);

}  // namespace flare::cli
