// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/encoder_set.h"

#include <algorithm>

#include "protocol/codec/json_writer.h"
#include "server/encoder/script_encoder.h"
#include "server/encoder/udp_encoder.h"
#include "server/encoder/usb_encoder.h"

namespace flare {
namespace {

using wire::JsonWriter;

constexpr char kNoPriority[] =
    "encoders: real-time priority for the threads that read USB devices is refused: while requests "
    "keep every core busy, a turn of a ring is seen up to 0.1 s late. Allow it with LimitRTPRIO=1 "
    "in "
    "the systemd unit (ulimit -r 1), or with the capability CAP_SYS_NICE";

// What is not measured is left out; focus at infinity becomes null, as in a request.
void WriteState(JsonWriter& json, const LensReading& reading) {
    const std::optional<double>& focus = reading[LensAxis::kFocus];
    const std::optional<double>& iris = reading[LensAxis::kIris];
    json.Key("state").BeginInlineObject();
    if (focus) json.Member("focus_m", *focus);
    if (iris) json.Member(reading.iris_is_t_stop ? "t_stop" : "f_number", *iris);
    if (reading[LensAxis::kZoom]) json.Member("zoom_mm", *reading[LensAxis::kZoom]);
    json.End();
}

void WriteEncoder(JsonWriter& json, const EncoderTrack& track, double now_s) {
    const EncoderStatus status = track.Status(now_s);
    const EncoderConfig& config = track.config();
    json.BeginObject().Member("name", config.name).Member("kind", Name(config.kind));
    json.Member("health", Name(status.health)).Member("connected", status.connected);
    json.Member("description", status.description).Member("lens", track.lens());
    json.Member("samples", status.samples).Member("rate_hz", status.rate_hz);
    json.Member("problem", status.problem);
    if (status.newest) {
        json.Member("time_s", status.newest->time_s);
        json.Member("age_ms", 1e3 * (now_s - status.newest->time_s));
        WriteState(json, status.newest->reading);
        json.Key("raw").BeginInlineObject();
        for (const LensAxis axis : kLensAxes) {
            if (const auto& raw = status.newest->raw[Index(axis)]) json.Member(Name(axis), *raw);
        }
        json.End();
    }
    json.Key("smooth_ms").BeginInlineObject();
    for (const LensAxis axis : kLensAxes) {
        json.Member(Name(axis), config.calibration.axes[Index(axis)].smooth_ms);
    }
    json.End().Key("faults").BeginInlineObject();
    for (std::size_t i = 0; i < status.faults.size(); ++i) {
        json.Member(kEncoderFaultNames[i], status.faults[i]);
    }
    json.End().End();
}

bool IsUsb(EncoderKind kind) {
    return kind == EncoderKind::kQsb || kind == EncoderKind::kCooke || kind == EncoderKind::kHid;
}

// The source that the track's config asks for.
Result<std::unique_ptr<EncoderSource>> StartSource(EncoderTrack& track) {
    if (IsUsb(track.config().kind)) return StartUsb(track);
    switch (track.config().kind) {
        case EncoderKind::kScript:
            return StartScript(track);
        case EncoderKind::kFreeD:
        case EncoderKind::kOpenTrackIo:
            return StartUdp(track);
        default:
            break;
    }
    return Error{"bad_config", "there is no such kind of encoder", "kind"};
}

}  // namespace

Result<std::unique_ptr<EncoderSet>> EncoderSet::Start(const std::vector<EncoderConfig>& configs,
                                                      const EncoderLog& log) {
    auto set = std::make_unique<EncoderSet>();
    for (const EncoderConfig& config : configs) {
        auto track = std::make_unique<EncoderTrack>(config, log);
        Result<std::unique_ptr<EncoderSource>> source = StartSource(*track);
        if (!source) {
            Error error = source.error();
            error.where = "encoder " + config.name + ", " + error.where;
            return error;
        }
        set->tracks_.push_back(std::move(track));
        set->sources_.push_back(std::move(*source));
    }
    const bool any_usb = std::any_of(configs.begin(), configs.end(),
                                     [](const auto& config) { return IsUsb(config.kind); });
    if (any_usb && !MayGoBeforeRequests()) log(true, kNoPriority);
    return set;
}

const EncoderTrack* EncoderSet::Find(std::string_view name) const {
    for (const auto& track : tracks_) {
        if (track->config().name == name) return track.get();
    }
    return nullptr;
}

std::string EncodersJson(const EncoderSet& encoders) {
    const double now_s = EncoderClock::Now_s();
    JsonWriter json(JsonWriter::Style::kPretty);
    json.BeginObject().Key("encoders").BeginArray();
    for (const auto& track : encoders.tracks()) WriteEncoder(json, *track, now_s);
    json.End().End();
    return json.Take();
}

}  // namespace flare
