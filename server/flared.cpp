// SPDX-License-Identifier: Apache-2.0
//
// flared: reads its configuration, opens its sockets, serves until SIGTERM or SIGINT, drains. Exit
// codes: 0 drained; 2 bad usage or configuration; 1 anything else. A second signal ends the drain.
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <thread>

#include "core/base/keep_memory.h"
#include "protocol/limits.h"
#include "protocol/openapi.h"
#include "server/cache/disk_cache.h"
#include "server/cache/ghost_cache.h"
#include "server/cache/mesh_cache.h"
#include "server/cache/program_identity.h"
#include "server/config.h"
#include "server/daemon.h"
#include "server/encoder/encoder_set.h"
#include "server/lens_services.h"
#include "server/picture_memory.h"
#include "server/translate/lens_json.h"

namespace flare {
namespace {

constexpr int kBadUsage = 2;
constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::chrono::milliseconds kDrainPoll{50};
constexpr std::chrono::milliseconds kDiskPoll{5};
constexpr double kLookAtRings_ms = 20.0;
constexpr std::size_t kCacheShareAhead = 4;  // of the cache that one encoder may have ahead

int Fail(int exit_code, const Error& error) {
    std::cerr << "flared: " << (error.where.empty() ? "" : error.where + ": ") << error.message
              << '\n';
    return exit_code;
}

struct CommandLine {
    std::string config_file, lenses, disk_cache, log_level;
    std::vector<std::string> listen;
    std::map<std::string, std::int64_t> numbers;  // by parameter
};

void DescribeOptions(CLI::App& app, CommandLine& line) {
    app.set_version_flag("--version", std::string("flared " FLARE_VERSION));
    app.add_option("--config", line.config_file, "TOML file; the command line overrides it");
    app.add_option("--lenses", line.lenses, "folder of lens files");
    app.add_option("--disk-cache", line.disk_cache, "folder of mesh files that outlive the daemon");
    app.add_option("--listen", line.listen, "unix:/path or http://127.0.0.1:PORT; may be repeated")
        ->allow_extra_args(false);
    app.add_option("--log-level", line.log_level, "trace, debug, info, warn, error or off");
    for (const Parameter& parameter : Parameters()) {
        const std::string name(parameter.name);
        std::string option = "--" + name;
        std::replace(option.begin(), option.end(), '_', '-');
        app.add_option_function<std::int64_t>(
            option, [&line, name](const std::int64_t& value) { line.numbers[name] = value; },
            std::string(parameter.help));
    }
}

Result<Config> ReadConfigFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream text;
    if (!file || !(text << file.rdbuf())) {
        return Error{"bad_config", "cannot read " + path, ""};
    }
    Result<Config> config = ReadConfig(text.str(), {});
    if (config) return config;
    Error error = config.error();
    error.where = path + ", " + error.where;
    return error;
}

Result<Config> MakeConfig(const CommandLine& line) {
    Config config;
    if (!line.config_file.empty()) {
        Result<Config> read = ReadConfigFile(line.config_file);
        if (!read) return read;
        config = *read;
    }
    if (!line.listen.empty()) config.listen = line.listen;
    if (!line.lenses.empty()) config.lenses = line.lenses;
    if (!line.disk_cache.empty()) config.disk_cache = line.disk_cache;
    if (!line.log_level.empty()) config.log_level = line.log_level;
    for (const Parameter& parameter : Parameters()) {
        const auto given = line.numbers.find(std::string(parameter.name));
        if (given == line.numbers.end()) continue;
        const Result<std::int64_t> value = CheckParameter(parameter, given->second);
        if (!value) return value.error();
        config.*parameter.member = *value;
    }
    Result<Config> checked = CheckConfig(config);
    if (!checked) return checked;
    return FillFromMachine(*checked);
}

Result<std::vector<ListeningSocket>> OpenSockets(const Config& config) {
    std::vector<ListeningSocket> sockets;
    for (const std::string& address : config.listen) {
        Result<ListeningSocket> socket =
            ListeningSocket::Open(address, {config.allow_remote, config.socket_mode_bits()});
        if (!socket) return socket.error();
        sockets.push_back(std::move(*socket));
    }
    return sockets;
}

DaemonOptions OptionsFrom(const Config& config) {
    DaemonOptions options;
    options.version = FLARE_VERSION;
    options.http.header_bytes = limits::kHeaderBytes;
    options.http.target_bytes = limits::kTargetBytes;
    options.http.body_bytes = limits::kBodyBytes;
    options.http.connections = static_cast<std::size_t>(config.connections);
    options.http.idle = std::chrono::seconds(config.idle_timeout_s);
    options.http.header = std::chrono::seconds(config.header_timeout_s);
    options.http.body = std::chrono::seconds(config.body_timeout_s);
    options.http.reply = std::chrono::seconds(config.reply_timeout_s);
    options.schedule.workers = static_cast<int>(config.workers);
    options.schedule.queue = static_cast<std::size_t>(config.queue);
    options.schedule.picture_bytes = static_cast<std::uint64_t>(config.picture_mb) * kMiB;
    options.schedule.background = limits::kWarmJobs;
    options.schedule.deadline = std::chrono::seconds(config.deadline_s);
    return options;
}

double NowMs() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration<double, std::milli>(now).count();
}

std::unique_ptr<DiskCache> DiskCacheFrom(const Config& config) {
    if (config.disk_cache_mb == 0) return nullptr;
    DiskCacheOptions options;
    options.folder = config.disk_cache;
    options.max_bytes = static_cast<std::uint64_t>(config.disk_cache_mb) * kMiB;
    options.identity = ProgramIdentity();
    options.log = [](const std::string& text) { spdlog::warn("{}", text); };
    return std::make_unique<DiskCache>(std::move(options));
}

WarmTask TaskFrom(const std::shared_ptr<WarmWork>& work, ThreadPool& threads, MeshCache& meshes,
                  const DiskCache* disk) {
    WarmTask task;
    task.step = [work, &threads, &meshes, disk](const CancelToken& cancel) {
        // Tracing ahead of the disk would only have meshes dropped that are to be kept.
        if (disk && disk->crowded()) {
            std::this_thread::sleep_for(kDiskPoll);
            return true;
        }
        return work->Step(threads, meshes, cancel);
    };
    task.progress = [work] { return work->progress(); };
    return task;
}

// Looks where the lens rings turn, and has what they come to traced while no request is there. A
// step may still be done when this has returned: what is given here outlives the daemon.
void FollowRings(const StopSignal& stop, WarmAhead& ahead, Daemon& daemon, ThreadPool& threads,
                 MeshProvider& meshes) {
    const auto under_way = std::make_shared<std::atomic<bool>>(false);
    const auto step = [under_way, &ahead, &threads, &meshes] {
        bool more = false;
        try {
            more = ahead.Step(threads, meshes);
        } catch (const std::exception& problem) {
            spdlog::error("warming ahead of a lens ring failed: {}", problem.what());
        }
        *under_way = more;
        return more;
    };
    while (!stop.WaitFor_ms(kLookAtRings_ms)) {
        if (!ahead.Look(EncoderClock::Now_s()) || under_way->exchange(true)) continue;
        if (!daemon.SubmitBackground(step)) *under_way = false;
    }
}

std::vector<EncoderCounts> CountsOf(const EncoderSet& encoders, const WarmAhead& ahead) {
    std::vector<EncoderCounts> all;
    for (const auto& track : encoders.tracks()) {
        const EncoderStatus status = track->Status(EncoderClock::Now_s());
        const std::string& name = track->config().name;
        EncoderCounts counts{name, status.connected, status.samples, {}, ahead.states(name)};
        for (std::size_t i = 0; i < status.faults.size(); ++i) {
            counts.faults.emplace_back(kEncoderFaultNames[i], status.faults[i]);
        }
        all.push_back(std::move(counts));
    }
    return all;
}

DaemonServices ServicesFrom(const LensLibrary& lenses, ThreadPool& threads, MeshCache& meshes,
                            const DiskCache* disk, GhostCache& ghosts, const EncoderSet& encoders,
                            WarmAhead& ahead) {
    const auto spare = std::make_shared<SpareBytes>();
    const auto context = [&, spare](const CancelToken& cancel) {
        return ServiceContext{lenses,      threads,   meshes, cancel, NowMs,
                              spare.get(), &encoders, &ahead, &ghosts};
    };
    DaemonServices services;
    services.spare = spare;
    services.flare = [context](std::string_view body, ReplyFormat format, const std::string& id,
                               const CancelToken& cancel) {
        return ServeFlare(body, format, id, context(cancel));
    };
    services.picture_bytes = PictureBytesOfBody;
    services.ghosts = [context](const std::string& lens, const GhostQuery& query,
                                const CancelToken& cancel) {
        return ServeGhosts(lens, query, context(cancel));
    };
    services.lens = [&lenses](const std::string& name, const LensState& state) {
        return ServeLens(name, state, lenses);
    };
    services.warm = [&lenses, &threads, &meshes, disk](std::string_view body) -> Result<WarmTask> {
        const Result<std::shared_ptr<WarmWork>> work = WarmWork::Plan(body, lenses);
        if (!work) return work.error();
        return TaskFrom(*work, threads, meshes, disk);
    };
    services.encoders = [&encoders] { return EncodersJson(encoders); };
    services.encoder_counts = [&encoders, &ahead] { return CountsOf(encoders, ahead); };
    services.lens_list = LensListJson(lenses);
    services.openapi = OpenApiDocument();
    services.cache = [&meshes, disk, &ghosts] {
        return CacheReadings{meshes.stats(), meshes.rays_traced(),
                             disk ? disk->stats() : DiskCacheStats{}, ghosts.stats()};
    };
    return services;
}

sigset_t StopSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    return signals;
}

// Waits for a signal, then drains; a second signal cuts the drain short.
void ServeUntilStopped(Daemon& daemon, const Config& config) {
    const sigset_t signals = StopSignals();
    int signal_number = 0;
    sigwait(&signals, &signal_number);
    spdlog::info("signal {}: draining for at most {} s", signal_number, config.drain_s);
    daemon.StartDraining();
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(config.drain_s);
    const timespec no_wait{0, 0};
    while (!daemon.WaitUntilDrained(kDrainPoll)) {
        const bool again = sigtimedwait(&signals, nullptr, &no_wait) > 0;
        if (!again && std::chrono::steady_clock::now() < end) continue;
        spdlog::warn("cutting off what is left of the work");
        daemon.CutOff();
        return;
    }
    spdlog::info("drained");
}

int Serve(const Config& config) {
    const std::string folder = config.lenses.empty() ? DefaultLensDirectory() : config.lenses;
    const Result<LensLibrary> lenses = LensLibrary::Load(folder);
    if (!lenses) return Fail(kBadUsage, lenses.error());
    for (const auto& [name, error] : lenses->broken()) {
        spdlog::warn("lens {} cannot be used: {}: {}", name, error.where, error.message);
    }
    Result<std::vector<ListeningSocket>> sockets = OpenSockets(config);
    if (!sockets) {
        return Fail(sockets.error().code == "bad_address" ? kBadUsage : 1, sockets.error());
    }
    std::vector<std::string> urls;
    for (const ListeningSocket& socket : *sockets) urls.push_back(socket.url());

    const EncoderLog log = [](bool warning, const std::string& text) {
        spdlog::log(warning ? spdlog::level::warn : spdlog::level::info, "{}", text);
    };
    const Result<std::unique_ptr<EncoderSet>> encoders = EncoderSet::Start(config.encoders, log);
    if (!encoders) return Fail(kBadUsage, encoders.error());

    ThreadPool threads(static_cast<int>(config.threads));
    const std::unique_ptr<DiskCache> disk = DiskCacheFrom(config);
    MeshCache meshes(static_cast<std::size_t>(config.cache_mb) * kMiB, disk.get());
    GhostCache ghosts(static_cast<std::size_t>(config.ghost_cache_mb) * kMiB);
    WarmAhead ahead(
        *lenses, [&set = **encoders](std::string_view name) { return set.Find(name); },
        static_cast<std::size_t>(config.cache_mb) * kMiB / kCacheShareAhead);
    MeshesInMemory meshes_ahead(meshes);
    Daemon daemon(OptionsFrom(config),
                  ServicesFrom(*lenses, threads, meshes, disk.get(), ghosts, **encoders, ahead),
                  std::move(*sockets));
    std::optional<SourceThread> follower;
    if (!config.encoders.empty()) {
        follower.emplace([&](const StopSignal& stop) {
            FollowRings(stop, ahead, daemon, threads, meshes_ahead);
        });
    }
    // Scripts wait for these lines and read the port from them.
    for (const std::string& url : urls) std::cout << "listening " << url << '\n';
    std::cout << std::flush;
    spdlog::info("{} lenses from {}; {} workers, {} threads; meshes {}", lenses->Names().size(),
                 folder, config.workers, config.threads,
                 disk ? "also in " + config.disk_cache : "in memory alone");
    ServeUntilStopped(daemon, config);
    return 0;
}

int Main(int argc, char** argv) {
    CLI::App app("Renders lens flares from lens prescriptions, over HTTP", "flared");
    CommandLine line;
    DescribeOptions(app, line);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& problem) {
        return app.exit(problem) == 0 ? 0 : kBadUsage;
    }
    const Result<Config> config = MakeConfig(line);
    if (!config) return Fail(kBadUsage, config.error());
    spdlog::set_default_logger(spdlog::stderr_color_mt("flared"));
    spdlog::set_level(spdlog::level::from_str(config->log_level));

    // Before any thread exists, so that all inherit it: signals are taken by sigwait alone, and a
    // peer that closed its end is an error code, not a signal.
    const sigset_t signals = StopSignals();
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    signal(SIGPIPE, SIG_IGN);
    return Serve(*config);
}

}  // namespace
}  // namespace flare

int main(int argc, char** argv) {
    flare::KeepFreedMemory();
    try {
        return flare::Main(argc, argv);
    } catch (const std::exception& problem) {
        std::cerr << "flared: " << problem.what() << '\n';
        return 1;
    }
}
