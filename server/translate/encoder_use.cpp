// SPDX-License-Identifier: Apache-2.0
#include "server/translate/encoder_use.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

#include "core/optics/glass.h"
#include "core/optics/paraxial.h"
#include "protocol/codec/json_writer.h"
#include "protocol/limits.h"
#include "server/translate/ring_steps.h"

namespace flare {
namespace {

double FNumberInRange(double f_number) {
    return std::clamp(f_number, limits::kMinFNumber, limits::kMaxFNumber);
}

std::string UtcText(double time_s) {
    const double whole_s = std::floor(time_s);
    const auto seconds = static_cast<std::time_t>(whole_s);
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    char date[32], text[40];
    std::strftime(date, sizeof date, "%Y-%m-%dT%H:%M:%S", &utc);
    std::snprintf(text, sizeof text, "%s.%03dZ", date, static_cast<int>(1e3 * (time_s - whole_s)));
    return text;
}

std::string StateText(const LensReading& reading, const wire::LensChoice& lens) {
    wire::JsonWriter json(wire::JsonWriter::Style::kCompact);
    json.BeginObject();
    if (reading[LensAxis::kFocus]) {
        json.Member("focus_m", lens.focus_m.value_or(std::numeric_limits<double>::infinity()));
    }
    if (reading[LensAxis::kIris] && lens.f_number) json.Member("f_number", *lens.f_number);
    if (reading[LensAxis::kZoom] && lens.zoom_mm) json.Member("zoom_mm", *lens.zoom_mm);
    json.End();
    return json.Take();
}

Result<EncoderUse> Look(const wire::EncoderChoice& choice, const EncoderTrack& track) {
    const double now_s = EncoderClock::Now_s();
    const double time_s = choice.time_s.value_or(now_s);
    const auto at = [](Error error, const char* where) {
        error.where = where;
        return error;
    };
    EncoderUse use;
    use.name = choice.name;
    use.kind = Name(track.config().kind);
    use.live = !choice.time_s;
    if (choice.time_s) {
        const Result<TimedReading> timed = track.At(time_s);
        if (!timed) {
            return at(timed.error(),
                      timed.error().code == "encoder_time" ? "/encoder_time" : "/encoder");
        }
        use.timed = *timed;
    } else {
        const std::optional<TimedReading> newest = track.Newest();
        if (!newest) {
            return Error{"encoder_stale",
                         "the encoder '" + choice.name + "' has given no state yet", "/encoder"};
        }
        use.timed = *newest;
    }
    const auto& values = use.timed.reading.values;
    if (std::none_of(values.begin(), values.end(), [](const auto& v) { return v.has_value(); })) {
        return Error{"bad_value",
                     "the encoder '" + choice.name +
                         "' gives counts and nothing that they mean: it has no table "
                         "(flare encoder calibrate makes one)",
                     "/encoder"};
    }
    use.age_ms = std::max(0.0, 1e3 * (time_s - use.timed.time_s));
    if (choice.max_age_ms && use.age_ms > *choice.max_age_ms) {
        char text[100];
        std::snprintf(text, sizeof text, "the encoder's state is %.0f ms old, more than %g ms",
                      use.age_ms, *choice.max_age_ms);
        return Error{"encoder_stale", text, "/encoder_max_age_ms"};
    }
    return use;
}

// The values but for a T-stop. A number that stands in the request as well is refused.
std::optional<Error> PutIn(const LensReading& reading, wire::LensChoice& lens) {
    const auto twice = [](const char* where) {
        return Error{"bad_value", "the encoder gives this value; leave one of them out", where};
    };
    if (const auto& focus = reading[LensAxis::kFocus]) {
        if (lens.focus_m) return twice("/focus_m");
        if (*focus <= limits::kMaxDistance_m) lens.focus_m = *focus;
    }
    if (const auto& zoom = reading[LensAxis::kZoom]) {
        if (lens.zoom_mm) return twice("/zoom_mm");
        lens.zoom_mm = std::min(*zoom, limits::kMaxZoom_mm);
    }
    if (const auto& iris = reading[LensAxis::kIris]) {
        if (lens.f_number) return twice("/f_number");
        if (!reading.iris_is_t_stop) lens.f_number = FNumberInRange(*iris);
    }
    return std::nullopt;
}

}  // namespace

Result<std::optional<EncoderUse>> TakeFromEncoder(wire::FlareRequest& request,
                                                  const EncoderSet* encoders,
                                                  const LensLibrary& lenses) {
    if (!request.encoder) return std::optional<EncoderUse>();
    const EncoderTrack* const track = encoders ? encoders->Find(request.encoder->name) : nullptr;
    if (!track) {
        return Error{"unknown_encoder", "there is no encoder '" + request.encoder->name + "'",
                     "/encoder"};
    }
    Result<EncoderUse> use = Look(*request.encoder, *track);
    if (!use) return use.error();
    const bool lens_named = request.lens.name || request.lens.prescription;
    if (!lens_named) request.lens.name = track->lens();
    if (use->live && request.lens.name) {
        // One that is not there is refused when the request is understood.
        if (const auto lens = lenses.Find(*request.lens.name)) {
            LensReading& reading = use->timed.reading;
            reading = RingSteps::For(**lens, request).Rounded(reading);
        }
    }
    if (const auto error = PutIn(use->timed.reading, request.lens)) return *error;
    if (!lens_named && request.lens.name->empty()) {
        return Error{
            "missing_field",
            "the request names no lens, and the encoder '" + use->name + "' does not either",
            "/lens"};
    }
    request.encoder.reset();
    return std::optional(std::move(*use));
}

void SetTStop(const EncoderUse& use, wire::FlareRequest& request, FlareRequest& translated) {
    const LensReading& reading = use.timed.reading;
    const auto& iris = reading[LensAxis::kIris];
    if (!iris || !reading.iris_is_t_stop) return;
    const double t_axis = AxialTransmittance(*translated.lens, kLineD);
    request.lens.f_number = FNumberInRange(*iris * std::sqrt(t_axis));
    translated.f_number = request.lens.f_number;
}

void AddEncoderAttributes(const EncoderUse& use, const wire::LensChoice& lens, FlareImage& image) {
    image.text_attributes.emplace_back("encoder", use.name);
    image.text_attributes.emplace_back("encoderKind", use.kind);
    image.text_attributes.emplace_back("encoderTime", UtcText(use.timed.time_s));
    auto& numbers = image.number_attributes;
    const LensReading& reading = use.timed.reading;
    numbers.emplace_back("encoderAge", use.age_ms);
    const auto& focus = reading[LensAxis::kFocus];
    if (focus && std::isfinite(*focus)) numbers.emplace_back("encoderFocus", *focus);
    if (const auto& iris = reading[LensAxis::kIris]) {
        numbers.emplace_back(reading.iris_is_t_stop ? "encoderTStop" : "encoderFNumber", *iris);
    }
    if (const auto& zoom = reading[LensAxis::kZoom]) numbers.emplace_back("encoderZoom", *zoom);
    image.text_attributes.emplace_back("encoderState", StateText(reading, lens));
}

}  // namespace flare
