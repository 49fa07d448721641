// SPDX-License-Identifier: Apache-2.0
//
// One HID device: its reports as they come.
#pragma once

#include "server/encoder/encoder_source.h"
#include "server/encoder/usb_port.h"

namespace flare {

class HidTalk {
  public:
    HidTalk(HidPort& port, EncoderTrack& track, const StopSignal& stop)
        : port_(port), track_(track), stop_(stop) {}

    // What ended it; nothing if it was to stop.
    std::optional<UsbProblem> Run(const UsbFound& found);

  private:
    HidPort& port_;
    EncoderTrack& track_;
    const StopSignal& stop_;
};

}  // namespace flare
