// SPDX-License-Identifier: Apache-2.0
#include "server/config.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <thread>

#include "server/config_encoders.h"

namespace flare {
namespace {

constexpr std::array kParameters{
    Parameter{"threads", &Config::threads, 0, 1'024,
              "threads that share one request; 0: one a core"},
    Parameter{"workers", &Config::workers, 0, 1'024, "requests rendered at once; 0: one a core"},
    Parameter{"cache_mb", &Config::cache_mb, 0, 1 << 20, "MiB of ghost meshes kept"},
    Parameter{"ghost_cache_mb", &Config::ghost_cache_mb, 0, 1 << 20,
              "MiB of ghosts kept as they were drawn"},
    Parameter{"disk_cache_mb", &Config::disk_cache_mb, 0, 1 << 24,
              "MiB of ghost meshes kept on disk; 0: none"},
    Parameter{"picture_mb", &Config::picture_mb, 0, 1 << 24,
              "MiB of pictures in work at once; 0: half of the machine's memory"},
    Parameter{"queue", &Config::queue, 1, 65'536, "requests that may wait for a worker"},
    Parameter{"deadline_s", &Config::deadline_s, 1, 86'400,
              "seconds until a request is given up, its wait included"},
    Parameter{"drain_s", &Config::drain_s, 0, 86'400,
              "seconds that admitted requests get after SIGTERM"},
    Parameter{"connections", &Config::connections, 1, 65'536, "connections open at once"},
    Parameter{"idle_timeout_s", &Config::idle_timeout_s, 1, 86'400,
              "seconds of silence between requests of a connection"},
    Parameter{"header_timeout_s", &Config::header_timeout_s, 1, 3'600,
              "seconds for a request's head"},
    Parameter{"body_timeout_s", &Config::body_timeout_s, 1, 3'600, "seconds for a request's body"},
    Parameter{"reply_timeout_s", &Config::reply_timeout_s, 1, 3'600,
              "seconds for a client to take its reply, and one more for every MiB"},
};

constexpr std::array<std::string_view, 6> kLogLevels{"trace", "debug", "info",
                                                     "warn",  "error", "off"};

Error BadConfig(std::string message, std::string where) {
    return {"bad_config", std::move(message), std::move(where)};
}

// Each Read... returns what is wrong with the node, or "".
std::string ReadText(const toml::node& node, std::string& target) {
    const auto* text = node.as_string();
    if (!text) return "needs a string";
    target = text->get();
    return "";
}

std::string ReadListen(const toml::node& node, std::vector<std::string>& target) {
    const toml::array* list = node.as_array();
    if (!list) return "needs an array of strings";
    std::vector<std::string> addresses;
    for (const toml::node& item : *list) {
        const auto* text = item.as_string();
        if (!text) return "needs an array of strings";
        addresses.push_back(text->get());
    }
    target = std::move(addresses);
    return "";
}

std::string ReadNumber(const toml::node& node, const Parameter& parameter, Config& config) {
    const auto* number = node.as_integer();
    if (!number) return "needs a whole number";
    const Result<std::int64_t> checked = CheckParameter(parameter, number->get());
    if (!checked) return checked.error().message;
    config.*parameter.member = *checked;
    return "";
}

std::string ReadKey(std::string_view key, const toml::node& node, Config& config) {
    if (key == "listen") return ReadListen(node, config.listen);
    if (key == "lenses") return ReadText(node, config.lenses);
    if (key == "disk_cache") return ReadText(node, config.disk_cache);
    if (key == "log_level") return ReadText(node, config.log_level);
    if (key == "socket_mode") return ReadText(node, config.socket_mode);
    if (key == "allow_remote") {
        const auto* truth = node.as_boolean();
        if (!truth) return "needs true or false";
        config.allow_remote = truth->get();
        return "";
    }
    for (const Parameter& parameter : kParameters) {
        if (parameter.name == key) return ReadNumber(node, parameter, config);
    }
    return "is no key of a flared config";
}

std::optional<unsigned> ParseMode(std::string_view text) {
    if (text.size() < 3 || text.size() > 4) return std::nullopt;
    unsigned mode = 0;
    for (const char c : text) {
        if (c < '0' || c > '7') return std::nullopt;
        mode = mode * 8 + static_cast<unsigned>(c - '0');
    }
    if (mode > 0777) return std::nullopt;
    return mode;
}

// By the XDG base directory specification, which takes absolute paths alone.
std::string UserCacheFolder() {
    const auto absolute = [](const char* name) -> std::string {
        const char* const value = std::getenv(name);
        return value && value[0] == '/' ? value : "";
    };
    if (const std::string cache = absolute("XDG_CACHE_HOME"); !cache.empty()) {
        return cache + "/flared";
    }
    const std::string home = absolute("HOME");
    return home.empty() ? "" : home + "/.cache/flared";
}

}  // namespace

unsigned Config::socket_mode_bits() const {
    return ParseMode(socket_mode).value_or(0600);
}

std::span<const Parameter> Parameters() {
    return kParameters;
}

Result<std::int64_t> CheckParameter(const Parameter& parameter, std::int64_t value) {
    if (value >= parameter.low && value <= parameter.high) return value;
    return BadConfig("is " + std::to_string(value) + ", not from " + std::to_string(parameter.low) +
                         " to " + std::to_string(parameter.high),
                     std::string(parameter.name));
}

Result<Config> ReadConfig(std::string_view text, Config config) {
    const toml::parse_result parsed = toml::parse(text);
    if (!parsed) {
        return BadConfig(std::string(parsed.error().description()),
                         WhereOf(parsed.error().source()));
    }
    for (const auto& [key, node] : parsed.table()) {
        if (key == "encoder") {
            Result<std::vector<EncoderConfig>> encoders = ReadEncoders(node);
            if (!encoders) return encoders.error();
            config.encoders = std::move(*encoders);
            continue;
        }
        const std::string problem = ReadKey(key.str(), node, config);
        if (problem.empty()) continue;
        return BadConfig(std::string(key.str()) + " " + problem, WhereOf(key.source()));
    }
    return config;
}

Result<Config> CheckConfig(Config config) {
    if (config.listen.empty()) {
        return BadConfig("there is no address to listen on", "listen");
    }
    if (std::find(kLogLevels.begin(), kLogLevels.end(), config.log_level) == kLogLevels.end()) {
        return BadConfig(
            "'" + config.log_level + "' is no log level: trace, debug, info, warn, error or off",
            "log_level");
    }
    if (!ParseMode(config.socket_mode)) {
        return BadConfig("'" + config.socket_mode + "' are no octal permissions like 0660",
                         "socket_mode");
    }
    return config;
}

Config FillFromMachine(Config config) {
    const std::int64_t cores = std::max(1U, std::thread::hardware_concurrency());
    if (config.threads == 0) config.threads = cores;
    if (config.workers == 0) config.workers = cores;
    if (config.disk_cache.empty()) config.disk_cache = UserCacheFolder();
    if (config.disk_cache.empty()) config.disk_cache_mb = 0;
    if (config.picture_mb == 0) {
        const std::int64_t pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
        config.picture_mb = std::max<std::int64_t>(256, pages * page / 2 >> 20);
    }
    return config;
}

}  // namespace flare
