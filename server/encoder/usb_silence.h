// SPDX-License-Identifier: Apache-2.0
//
// Notices that a connected device says nothing for stale_ms: one fault for each silence.
#pragma once

#include "server/encoder/encoder_track.h"

namespace flare {

class UsbSilence {
  public:
    explicit UsbSilence(EncoderTrack& track) : track_(track) {}

    void Heard() {
        heard_s_ = EncoderClock::Now_s();
        told_ = false;
    }
    // True the first time that a silence has become too long.
    bool TooLong() {
        const double silent_ms = 1e3 * (EncoderClock::Now_s() - heard_s_);
        if (told_ || silent_ms < track_.config().stale_ms) return false;
        told_ = true;
        track_.Fault(EncoderFault::kTimeout, "the device says nothing");
        return true;
    }

  private:
    EncoderTrack& track_;
    double heard_s_ = EncoderClock::Now_s();
    bool told_ = false;
};

}  // namespace flare
