// SPDX-License-Identifier: Apache-2.0
#include "server/service.h"

#include <utility>

#include "core/image/exr.h"
#include "core/image/preview.h"
#include "core/render/renderer.h"
#include "protocol/codec/flare_request_codec.h"
#include "server/translate/encoder_use.h"
#include "server/translate/report_json.h"
#include "server/translate/request_from_wire.h"

namespace flare {
namespace {

struct Picture {
    std::string bytes;
    const char* content_type = "";
    std::uint64_t saturated_pixels = 0;
};

std::string SpareMemory(const ServiceContext& context) {
    return context.spare ? context.spare->Take() : std::string();
}

Picture Encode(const FlareImage& image, ReplyFormat format, const wire::Output& output,
               const ServiceContext& context) {
    ThreadPool& threads = context.threads;
    switch (format) {
        case ReplyFormat::kPng:
            return {EncodePng(image), "image/png", 0};
        case ReplyFormat::kHalfPlanes: {
            HalfPlanes half = EncodeHalfPlanes(image, threads, SpareMemory(context));
            return {std::move(half.bytes), "application/x-flare-half", half.saturated_pixels};
        }
        case ReplyFormat::kExr:
            break;
    }
    ExrOptions options;
    options.compression = output.compression == wire::Compression::kZip ? ExrCompression::kZip
                                                                        : ExrCompression::kNone;
    options.pixel = output.pixel == wire::PixelType::kHalf ? ExrPixel::kHalf : ExrPixel::kFloat;
    ExrBytes exr = EncodeExr(image, options, threads, SpareMemory(context));
    return {std::move(exr.bytes), "image/x-exr", exr.saturated_pixels};
}

}  // namespace

Result<ServiceReply> ServeFlare(std::string_view body, ReplyFormat format,
                                const std::string& report_id, const ServiceContext& context) {
    // Understand the request.
    wire::Decoded<wire::FlareRequest> decoded = wire::DecodeFlareRequest(body);
    if (const wire::Refusal* refusal = wire::RefusalOf(decoded)) {
        return Error{refusal->code, refusal->message, refusal->where};
    }
    auto& wire_request = std::get<wire::FlareRequest>(decoded);
    const Result<std::optional<EncoderUse>> encoder =
        TakeFromEncoder(wire_request, context.encoders, context.lenses);
    if (!encoder) return encoder.error();
    Result<FlareRequest> request = RequestFromWire(wire_request, context.lenses);
    if (!request) return request.error();
    if (*encoder) SetTStop(**encoder, wire_request, *request);

    Result<Rendering> rendering = Render(*request, {context.threads, context.meshes, context.cancel,
                                                    context.now_ms, context.keeper});
    if (!rendering) return rendering.error();
    FlareImage& image = rendering->image;
    Report& report = rendering->report;
    // What was looked for is from here on what was found, in the hash as well: asked for by its
    // tolerance the picture has the same bytes.
    const Quality asked = std::exchange(request->quality, rendering->quality);
    if (!asked.IsPlan()) {
        wire_request.quality = {};
        wire_request.quality.tolerance = rendering->quality.tolerance;
    }
    if (*encoder && (*encoder)->live && context.ahead) {
        context.ahead->Note((*encoder)->name, wire_request, (*encoder)->timed.reading,
                            EncoderClock::Now_s());
    }

    // Encode the picture with the facts that follow from the request alone.
    ReplyFacts facts;
    facts.id = report_id;
    facts.request_hash = RequestHash(wire_request, *request).hex();
    AddFactAttributes(*request, report.facts, facts.request_hash, image);
    if (*encoder) {
        AddEncoderAttributes(**encoder, wire_request.lens, image);
        facts.encoder = &**encoder;
    }
    const double start_ms = context.now_ms();
    Picture picture = Encode(image, format, wire_request.output, context);
    facts.encode_ms = context.now_ms() - start_ms;
    facts.asked = asked;
    facts.content_type = picture.content_type;
    facts.window = image.data;
    facts.bytes = picture.bytes.size();
    facts.threads = context.threads.threads();
    report.facts.saturated_pixels = picture.saturated_pixels;

    ServiceReply reply;
    reply.bytes = std::move(picture.bytes);
    reply.content_type = picture.content_type;
    reply.report_summary = ReportSummaryJson(*request, report, facts);
    reply.report = ReportJson(*request, report, facts);
    reply.request_hash = facts.request_hash;
    reply.work = {report.work.rays_traced, report.work.mesh_hits, report.work.mesh_misses};
    return reply;
}

}  // namespace flare
