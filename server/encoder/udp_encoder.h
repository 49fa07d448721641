// SPDX-License-Identifier: Apache-2.0
//
// Encoders that speak over UDP: FreeD and OpenTrackIO. The port is opened anew every second while
// it cannot be had. A sender is "connected" from its first good datagram until none came for
// stale_ms.
#pragma once

#include <memory>

#include "server/encoder/encoder_source.h"

namespace flare {

Result<std::unique_ptr<EncoderSource>> StartUdp(EncoderTrack& track);

}  // namespace flare
