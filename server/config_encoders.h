// SPDX-License-Identifier: Apache-2.0
//
// The [[encoder]] tables of a daemon's configuration (docs/encoders.md). Part of ReadConfig.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/encoder/encoder_config.h"

#define TOML_EXCEPTIONS 0
#include <toml++/toml.h>

namespace flare {

// "line 3, column 5"
std::string WhereOf(const toml::source_region& source);

// Errors: code "bad_config", `where` the place of the key.
Result<std::vector<EncoderConfig>> ReadEncoders(const toml::node& node);

}  // namespace flare
