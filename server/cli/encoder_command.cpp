// SPDX-License-Identifier: Apache-2.0
//
// flare encoder list and watch; calibrate stands in a file of its own.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <thread>

#include "server/cli/app.h"
#include "server/cli/encoder_view.h"
#include "server/cli/files.h"
#include "server/cli/options.h"
#include "server/cli/table.h"

namespace flare::cli {
namespace {

using wire::JsonKind;
using wire::JsonView;

struct EncoderOptions {
    std::string server, config;
    std::string name;
    bool json = false;
    double interval_ms = 100.0;
    int count = 0;  // 0: until interrupted
};

int ExitFor(const Error& error) {
    Complain("", error);
    return error.code == "no_server" ? kServerFailed : kBadInput;
}

std::string TextOf(const JsonView& object, std::string_view name) {
    const auto member = object.Find(name);
    return member && member->kind() == JsonKind::kString ? std::string(member->string()) : "";
}

std::string NumberText(const JsonView& number, const char* format) {
    if (number.kind() != JsonKind::kNumber) return "inf";  // the one null of a state
    char text[40];
    std::snprintf(text, sizeof text, format, number.number());
    return text;
}

std::string NumberOf(const JsonView& object, std::string_view name, const char* format) {
    const auto member = object.Find(name);
    return member ? NumberText(*member, format) : "";
}

// "2.5 m, T2.8, 50 mm"; "-" without a state.
std::string StateOf(const JsonView& encoder) {
    const auto state = encoder.Find("state");
    if (!state || state->kind() != JsonKind::kObject || state->child_count() == 0) return "-";
    std::string text;
    for (auto value = state->FirstChild(); value; value = value->NextSibling()) {
        if (!text.empty()) text += ", ";
        if (value->key() == "focus_m") text += NumberText(*value, "%.5g") + " m";
        if (value->key() == "t_stop") text += "T" + NumberText(*value, "%.4g");
        if (value->key() == "f_number") text += "f/" + NumberText(*value, "%.4g");
        if (value->key() == "zoom_mm") text += NumberText(*value, "%.5g") + " mm";
    }
    return text;
}

std::string RawOf(const JsonView& encoder) {
    const auto raw = encoder.Find("raw");
    if (!raw || raw->kind() != JsonKind::kObject) return "";
    std::string text;
    for (auto value = raw->FirstChild(); value; value = value->NextSibling()) {
        text += (text.empty() ? "" : " ") + std::string(value->key()) + "=" +
                NumberText(*value, "%.10g");
    }
    return text;
}

int List(const EncoderOptions& options) {
    const Result<EncoderView> view = EncoderView::Open(options.server, options.config);
    if (!view) return ExitFor(view.error());
    if (options.json) {
        const Result<std::string> text = view->Text();
        return text ? Print(*text) : ExitFor(text.error());
    }
    const Result<wire::JsonDocument> document = view->Document();
    if (!document) return ExitFor(document.error());
    const auto list = document->root().Find("encoders");
    if (!list || list->child_count() == 0) return Print("no encoders are configured\n");
    Table table({"name", "kind", "health", "state", "age", "rate", "device"});
    std::string problems;
    for (auto encoder = list->FirstChild(); encoder; encoder = encoder->NextSibling()) {
        table.AddRow({TextOf(*encoder, "name"), TextOf(*encoder, "kind"),
                      TextOf(*encoder, "health"), StateOf(*encoder),
                      NumberOf(*encoder, "age_ms", "%.0f ms"),
                      NumberOf(*encoder, "rate_hz", "%.0f/s"), TextOf(*encoder, "description")});
        const std::string problem = TextOf(*encoder, "problem");
        if (!problem.empty()) problems += TextOf(*encoder, "name") + ": " + problem + "\n";
    }
    return Print(table.text() + problems);
}

int Watch(const EncoderOptions& options) {
    const Result<EncoderView> view = EncoderView::Open(options.server, options.config);
    if (!view) return ExitFor(view.error());
    for (int shown = 0; options.count == 0 || shown < options.count; ++shown) {
        if (shown > 0) {
            std::this_thread::sleep_for(
                std::chrono::duration<double, std::milli>(options.interval_ms));
        }
        const Result<wire::JsonDocument> document = view->Document();
        if (!document) return ExitFor(document.error());
        const auto encoder = FindEncoder(*document, options.name);
        if (!encoder) {
            return ExitFor({"unknown_encoder", "there is no encoder '" + options.name + "'", ""});
        }
        const std::string line = TextOf(*encoder, "health") + "  " + StateOf(*encoder) + "  " +
                                 RawOf(*encoder) + "  " +
                                 NumberOf(*encoder, "age_ms", "%.1f ms old") + "\n";
        if (Print(line) != kDone) return kFailed;
        std::fflush(stdout);
    }
    return kDone;
}

}  // namespace

void AddEncoderCommands(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<EncoderOptions>();
    CLI::App* encoder = app.add_subcommand("encoder", "Lens encoders: the rings of real lenses");
    encoder->require_subcommand(1);

    CLI::App* list = encoder->add_subcommand("list", "All encoders with state and health");
    AddEncoderSource(*list, options->server, options->config);
    list->add_flag("--json", options->json, "JSON instead of a table");
    list->callback([options, &exit_code] { exit_code = List(*options); });

    CLI::App* watch = encoder->add_subcommand("watch", "Follow one encoder, a line each time");
    watch->add_option("name", options->name, "The encoder")->required()->type_name("NAME");
    AddEncoderSource(*watch, options->server, options->config);
    watch->add_option("--interval-ms", options->interval_ms, "Between two lines")
        ->check(FiniteIn(1.0, 1e6))
        ->capture_default_str();
    watch->add_option("--count", options->count, "Lines; 0: until interrupted")
        ->check(CLI::Range(0, 1'000'000'000))
        ->capture_default_str();
    watch->callback([options, &exit_code] { exit_code = Watch(*options); });
    AddCalibrateCommand(*encoder, exit_code);
}

}  // namespace flare::cli
