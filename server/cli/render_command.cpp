// SPDX-License-Identifier: Apache-2.0
//
// flare render: the same request, in process or by a daemon, to the same bytes.
#include <CLI/CLI.hpp>
#include <cstdio>

#include "protocol/client/client.h"
#include "protocol/codec/json_document.h"
#include "protocol/codec/json_writer.h"
#include "protocol/limits.h"
#include "server/cli/app.h"
#include "server/cli/encoder_view.h"
#include "server/cli/explain.h"
#include "server/cli/files.h"
#include "server/cli/progress.h"
#include "server/cli/request_images.h"
#include "server/service.h"

namespace flare::cli {
namespace {

struct RenderOptions {
    std::string request;
    std::string output;
    std::string server;
    std::string report;
    std::string lenses;
    std::string encoder;
    std::string config;
    bool explain = false;
    int threads = ThreadsOfThisMachine();
};

struct Format {
    ReplyFormat format = ReplyFormat::kExr;
    const char* content_type = "image/x-exr";
};

Result<Format> FormatOf(const std::string& output) {
    if (output == "-" || output.ends_with(".exr")) return Format{};
    if (output.ends_with(".png")) return Format{ReplyFormat::kPng, "image/png"};
    if (output.ends_with(".half")) {
        return Format{ReplyFormat::kHalfPlanes, "application/x-flare-half"};
    }
    return Error{"bad_value", "the output's name ends in .exr, .png or .half, or is -", ""};
}

int WriteResults(const RenderOptions& options, const std::string& bytes,
                 const std::string& report) {
    if (const auto error = WriteOutput(options.output, bytes)) return Complain("", *error);
    if (options.explain) std::fputs(ExplainReport(report).c_str(), stderr);
    if (options.report.empty()) return kDone;
    if (const auto error = WriteOutput(options.report, report)) return Complain("", *error);
    return kDone;
}

int RenderHere(const RenderOptions& options, const std::string& body, const Format& format) {
    const Result<LensLibrary> library = OpenLibrary(options.lenses);
    if (!library) return Complain("", library.error());
    Result<std::unique_ptr<EncoderSet>> encoders = StartEncoders(options.config);
    if (!encoders) return Complain("", encoders.error());
    WaitForStates(**encoders);
    ThreadPool threads(options.threads);
    TracingMeshProvider meshes;
    std::optional<Progress> progress(std::in_place, "rendering");
    const Result<ServiceReply> reply =
        ServeFlare(body, format.format, "",
                   {*library, threads, meshes, CancelToken(), NowMs, nullptr, encoders->get()});
    progress.reset();
    if (!reply) return Complain(options.request, reply.error());
    return WriteResults(options, reply->bytes, reply->report);
}

// The member `name` of a JSON object as text, "" if there is none.
std::string TextMember(const wire::JsonView& object, std::string_view name) {
    if (object.kind() != wire::JsonKind::kObject) return "";
    const std::optional<wire::JsonView> member = object.Find(name);
    if (!member || member->kind() != wire::JsonKind::kString) return "";
    return std::string(member->string());
}

// Says what the server said: {"error":{code, message, where}} or, from a stranger, the bare status.
int ComplainOfReply(const std::string& file, const client::Reply& reply) {
    Error error{"http_" + std::to_string(reply.status), "the server refused", ""};
    const auto parsed = wire::JsonDocument::Parse(reply.body);
    if (const auto* document = std::get_if<wire::JsonDocument>(&parsed)) {
        const wire::JsonView root = document->root();
        const auto said =
            root.kind() == wire::JsonKind::kObject ? root.Find("error") : std::nullopt;
        if (said) {
            error = {TextMember(*said, "code"), TextMember(*said, "message"),
                     TextMember(*said, "where")};
        }
    }
    Complain(file, error);
    return kServerFailed;
}

int ComplainOfServer(const std::string& message) {
    Complain("", {"no_server", message, ""});
    return kServerFailed;
}

// The whole report by the id in the reply's Flare-Report header.
Result<std::string> FetchReport(const RenderOptions& options, const client::Reply& reply) {
    const Error missing{"no_report", options.server + ": the server gave no report", ""};
    const auto parsed = wire::JsonDocument::Parse(reply.header("Flare-Report"));
    const auto* document = std::get_if<wire::JsonDocument>(&parsed);
    if (!document) return missing;
    const std::string id = TextMember(document->root(), "id");
    if (id.empty()) return missing;
    client::Request request;
    request.target = "/v1/reports/" + id;
    client::Reply report = client::Fetch(options.server, request);
    if (!report.ok() || report.status != 200) return missing;
    return std::move(report.body);
}

int RenderThere(const RenderOptions& options, const std::string& body, const Format& format) {
    client::Request request;
    request.method = "POST";
    request.target = "/v1/flare";
    request.headers = {{"Content-Type", "application/json"}, {"Accept", format.content_type}};
    request.body = body;
    std::optional<Progress> progress(std::in_place, "waiting for " + options.server);
    const client::Reply reply = client::Fetch(options.server, request);
    progress.reset();
    if (!reply.ok()) return ComplainOfServer(reply.error);
    if (reply.status != 200) return ComplainOfReply(options.request, reply);
    if (options.report.empty() && !options.explain) return WriteResults(options, reply.body, "");

    const Result<std::string> report = FetchReport(options, reply);
    if (!report) {
        Complain("", report.error());
        return kServerFailed;
    }
    return WriteResults(options, reply.body, *report);
}

// The request with the member "encoder" in front. One that is no object is left as it is, to be
// refused as such.
Result<std::string> WithEncoder(const std::string& body, const std::string& name) {
    const auto parsed = wire::JsonDocument::Parse(body);
    const auto* document = std::get_if<wire::JsonDocument>(&parsed);
    if (!document || document->root().kind() != wire::JsonKind::kObject) return body;
    if (document->root().Find("encoder")) {
        return Error{"bad_value", "the request names an encoder, and so does --encoder",
                     "/encoder"};
    }
    wire::JsonWriter quoted(wire::JsonWriter::Style::kCompact);
    quoted.Value(name);
    std::string member = "\"encoder\":" + quoted.Take();
    if (document->root().child_count() > 0) member += ',';
    return std::string(body).insert(body.find('{') + 1, member);
}

int Render(const RenderOptions& options) {
    const Result<Format> format = FormatOf(options.output);
    if (!format) return Complain(options.output, format.error());
    if (options.output == "-" && options.report == "-") {
        return Complain("",
                        {"bad_value", "picture and report cannot both go to standard output", ""});
    }
    Result<std::string> body = ReadInput(options.request);
    if (!body) return Complain("", body.error());
    body = WithImagesInside(*body, options.request);
    if (!body) return Complain(options.request, body.error());
    if (!options.encoder.empty()) {
        body = WithEncoder(*body, options.encoder);
        if (!body) return Complain(options.request, body.error());
    }
    return options.server.empty() ? RenderHere(options, *body, *format)
                                  : RenderThere(options, *body, *format);
}

}  // namespace

void AddRenderCommand(CLI::App& app, int& exit_code) {
    auto options = std::make_shared<RenderOptions>();
    CLI::App* command = app.add_subcommand("render", "Render the flare that a request describes");
    command->add_option("request", options->request, "The request, a JSON file or -")
        ->required()
        ->type_name("REQUEST.json");
    command
        ->add_option("-o,--output", options->output,
                     "Where the picture goes: .exr, .png (to look at), .half (raw planes), or - "
                     "for EXR on standard output")
        ->required()
        ->type_name("FILE");
    auto* server =
        command
            ->add_option("--server", options->server,
                         "Ask a daemon: unix:/path/to/socket or http://host:port; without it the "
                         "picture is rendered here")
            ->type_name("URL")
            ->check([](const std::string& url) -> std::string {
                const bool known = url.starts_with("unix:") || url.starts_with("http://");
                return known ? "" : url + " is neither unix:/path nor http://host:port";
            });
    command->add_option("--report", options->report, "Write the report, JSON, to a file or -")
        ->type_name("FILE");
    command->add_flag("--explain", options->explain,
                      "Say on standard error what was drawn, what was left out, and how much light "
                      "that is");
    command->add_option("--lenses", options->lenses, "The folder of lens files")
        ->type_name("DIR")
        ->excludes(server);
    command
        ->add_option("--encoder", options->encoder,
                     "Take focus, iris and zoom from this lens encoder: one of the daemon's, or of "
                     "--config")
        ->type_name("NAME");
    command
        ->add_option("--config", options->config,
                     "A daemon's configuration, for its encoders; they run while this command does")
        ->type_name("FILE")
        ->excludes(server);
    command->add_option("--threads", options->threads, "Threads to render with")
        ->check(CLI::Range(1, 256))
        ->capture_default_str()
        ->excludes(server);
    command->callback([options, &exit_code] { exit_code = Render(*options); });
}

}  // namespace flare::cli
