// SPDX-License-Identifier: Apache-2.0
//
// How a daemon is set up: defaults, then a TOML file, then the command line, each overriding the
// one before. One table (Parameters) describes every number that can be set: file reader, command
// line and --help come from it.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "server/encoder/encoder_config.h"

namespace flare {

struct Config {
    std::vector<std::string> listen{"http://127.0.0.1:7411"};
    std::string lenses;      // folder; "": the library that belongs to the program
    std::string disk_cache;  // folder of mesh files; "": the user's cache folder
    std::string log_level = "info";
    std::string socket_mode = "0600";  // octal permissions of a Unix socket
    bool allow_remote = false;
    std::vector<EncoderConfig> encoders;

    std::int64_t threads = 0;  // 0: one a core
    std::int64_t workers = 0;  // 0: one a core
    std::int64_t cache_mb = 1'024;
    std::int64_t ghost_cache_mb = 256;   // 0: no ghost is kept
    std::int64_t disk_cache_mb = 4'096;  // 0: no disk cache
    std::int64_t picture_mb = 0;         // 0: half of the machine's memory
    std::int64_t queue = 64;
    std::int64_t deadline_s = 300;
    std::int64_t drain_s = 30;
    std::int64_t connections = 256;
    std::int64_t idle_timeout_s = 60;
    std::int64_t header_timeout_s = 10;
    std::int64_t body_timeout_s = 60;
    std::int64_t reply_timeout_s = 30;

    unsigned socket_mode_bits() const;  // of a checked config
};

struct Parameter {
    std::string_view name;
    std::int64_t Config::*member;
    std::int64_t low, high;
    std::string_view help;
};

std::span<const Parameter> Parameters();

// Reads `toml` over `config`. Errors: code "bad_config", `where` "line 3, column 5".
Result<Config> ReadConfig(std::string_view toml, Config config);

// The empty optional of a number out of its range: code "bad_config", `where` the parameter's name.
Result<std::int64_t> CheckParameter(const Parameter& parameter, std::int64_t value);

// Checks the texts of a config from any source: log level, socket mode, at least one address.
Result<Config> CheckConfig(Config config);

// Numbers that were left to the machine are filled in, and the folder of the disk cache:
// $XDG_CACHE_HOME/flared or ~/.cache/flared. Without a home there is no disk cache: disk_cache_mb
// is then 0.
Config FillFromMachine(Config config);

}  // namespace flare
