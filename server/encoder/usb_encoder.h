// SPDX-License-Identifier: Apache-2.0
//
// Encoders on USB: QSB and Cooke /i behind an FTDI chip, generic HID. Each has a thread that looks
// for its device every 50 ms, opens it, speaks its protocol until it is gone, and looks again. A
// device is told by its ids and by its strings or serial number, and two that fit are refused: an
// FTDI chip's ids say nothing about what is behind it.
#pragma once

#include <memory>

#include "server/encoder/encoder_source.h"

namespace flare {

// Error code "bad_config" in a program that was built without USB.
Result<std::unique_ptr<EncoderSource>> StartUsb(EncoderTrack& track);

}  // namespace flare
