// SPDX-License-Identifier: Apache-2.0
#include "server/cli/encoder_view.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <thread>

#include "protocol/client/client.h"
#include "server/cli/files.h"
#include "server/config.h"

namespace flare::cli {
namespace {

constexpr std::chrono::seconds kPatience{2};
constexpr std::chrono::milliseconds kPoll{2};

}  // namespace

Result<std::unique_ptr<EncoderSet>> StartEncoders(const std::string& config_path) {
    std::vector<EncoderConfig> configs;
    if (!config_path.empty()) {
        const Result<std::string> text = ReadInput(config_path);
        if (!text) return text.error();
        Result<Config> config = ReadConfig(*text, {});
        if (!config) {
            Error error = config.error();
            error.where = config_path + ", " + error.where;
            return error;
        }
        configs = std::move(config->encoders);
    }
    return EncoderSet::Start(configs, [](bool warning, const std::string& text) {
        if (warning) std::fprintf(stderr, "flare: %s\n", text.c_str());
    });
}

void WaitForStates(const EncoderSet& encoders) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    const auto& tracks = encoders.tracks();
    while (std::chrono::steady_clock::now() < end &&
           std::any_of(tracks.begin(), tracks.end(),
                       [](const auto& track) { return track->samples() == 0; })) {
        std::this_thread::sleep_for(kPoll);
    }
}

void AddEncoderSource(CLI::App& command, std::string& server, std::string& config) {
    CLI::Option* option =
        command
            .add_option("--server", server,
                        "The daemon: unix:/path/to/socket or http://host:port; without it the one "
                        "at http://127.0.0.1:7411")
            ->type_name("URL");
    command
        .add_option("--config", config,
                    "Run the encoders of this configuration here; no daemon may hold them")
        ->type_name("FILE")
        ->excludes(option);
}

Result<EncoderView> EncoderView::Open(const std::string& server, const std::string& config) {
    EncoderView view;
    view.server_ = server.empty() ? Config().listen.front() : server;
    if (config.empty()) return view;
    Result<std::unique_ptr<EncoderSet>> encoders = StartEncoders(config);
    if (!encoders) return encoders.error();
    view.encoders_ = std::move(*encoders);
    WaitForStates(*view.encoders_);
    return view;
}

Result<std::string> EncoderView::Text() const {
    if (encoders_) return EncodersJson(*encoders_);
    client::Request request;
    request.target = "/v1/encoders";
    client::Reply reply = client::Fetch(server_, request);
    if (!reply.ok()) return Error{"no_server", reply.error, ""};
    if (reply.status != 200) {
        return Error{"no_server",
                     server_ + ": status " + std::to_string(reply.status) + " for /v1/encoders",
                     ""};
    }
    return std::move(reply.body);
}

Result<wire::JsonDocument> EncoderView::Document() const {
    const Result<std::string> text = Text();
    if (!text) return text.error();
    auto parsed = wire::JsonDocument::Parse(*text);
    if (auto* document = std::get_if<wire::JsonDocument>(&parsed)) return std::move(*document);
    return Error{"no_server", server_ + ": the answer is no JSON", ""};
}

std::optional<wire::JsonView> FindEncoder(const wire::JsonDocument& document,
                                          const std::string& name) {
    const wire::JsonView root = document.root();
    const auto list = root.kind() == wire::JsonKind::kObject ? root.Find("encoders") : std::nullopt;
    if (!list || list->kind() != wire::JsonKind::kArray) return std::nullopt;
    for (auto child = list->FirstChild(); child; child = child->NextSibling()) {
        if (child->kind() != wire::JsonKind::kObject) continue;
        const auto found = child->Find("name");
        if (found && found->kind() == wire::JsonKind::kString && found->string() == name) {
            return child;
        }
    }
    return std::nullopt;
}

}  // namespace flare::cli
