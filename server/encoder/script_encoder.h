// SPDX-License-Identifier: Apache-2.0
//
// An encoder without hardware: replays a file. Its first line names the columns, time_s (seconds
// since the start, rising, required) and any of focus_m, t_stop or f_number, zoom_mm (values) and
// focus, iris, zoom (counts for the calibration tables); the others hold one number for each, or
// nothing where the ring was not read. Commas between; lines that begin with # and empty ones are
// passed over. "inf" is the focus at infinity.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "server/encoder/encoder_source.h"

namespace flare {

// Samples with times since the start. Error code "bad_script", `where` "line 3".
Result<std::vector<EncoderSample>> ReadScript(std::string_view text);

Result<std::unique_ptr<EncoderSource>> StartScript(EncoderTrack& track);

}  // namespace flare
