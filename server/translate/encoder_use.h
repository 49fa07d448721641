// SPDX-License-Identifier: Apache-2.0
//
// "encoder": "NAME" in a request: the state of a real lens at a moment, put in place of the numbers
// that it measures. Afterwards the request is the one with the numbers written out: same hash, same
// picture. What was used goes into the report and, as attributes named encoder..., into the
// picture.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "core/image/flare_image.h"
#include "core/render/flare_request.h"
#include "protocol/wire/flare_request.h"
#include "server/encoder/encoder_set.h"
#include "server/lens_library.h"

namespace flare {

struct EncoderUse {
    std::string name, kind;
    TimedReading timed;
    double age_ms = 0.0;  // of the reading, at the time that was asked for
    bool live = true;     // no time was asked for: the newest
};

// Takes the encoder out of the request and puts focus, zoom and f-stop, and the lens where none is
// named, in; nothing if the request has no encoder. The newest focus and zoom of a lens of the
// library are rounded where its meshes depend on them (ring_steps.h); those of a time are taken as
// they were. `encoders` may be null. Errors at
// "/encoder...", at a number that the encoder gives too, or at "/lens"; codes "unknown_encoder",
// "encoder_stale" (older than encoder_max_age_ms, or no state yet), "encoder_time" (before the kept
// history).
Result<std::optional<EncoderUse>> TakeFromEncoder(wire::FlareRequest& request,
                                                  const EncoderSet* encoders,
                                                  const LensLibrary& lenses);

// A T-stop needs the lens as it stands: N = T sqrt(t_axis), with t_axis the transmittance of the
// direct path on the axis at 587.5618 nm. Sets the f-number of both, if a T-stop was read.
void SetTStop(const EncoderUse& use, wire::FlareRequest& request, FlareRequest& translated);

// encoder, encoderKind, encoderTime (UTC), encoderAge (ms), encoderFocus (m; absent at infinity),
// encoderTStop or encoderFNumber, encoderZoom (mm), as floats; and encoderState, a text with every
// digit: what to write into a request in place of the encoder for the same picture, from `lens`,
// the request's own after both of the above.
void AddEncoderAttributes(const EncoderUse& use, const wire::LensChoice& lens, FlareImage& image);

}  // namespace flare
