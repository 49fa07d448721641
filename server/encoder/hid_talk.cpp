// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/hid_talk.h"

#include "server/encoder/hid_report.h"
#include "server/encoder/usb_silence.h"

namespace flare {
namespace {

// An endpoint that stalls again at once is given up and opened anew.
constexpr int kMostStalls = 3;

}  // namespace

std::optional<UsbProblem> HidTalk::Run(const UsbFound& found) {
    if (auto problem = port_.Open(found.device.get())) return problem;
    track_.Connected(found.description);
    UsbSilence silence(track_);
    int stalls = 0;
    while (!stop_.set()) {
        UsbRead read = port_.Read();
        const double now_s = EncoderClock::Now_s();
        if (read.problem) {
            if (read.problem->fault != EncoderFault::kStall || ++stalls > kMostStalls) {
                return read.problem;
            }
            track_.Fault(read.problem->fault, read.problem->text);
            port_.ClearStall();
            continue;
        }
        if (read.bytes.empty()) {
            silence.TooLong();
            continue;
        }
        stalls = 0;
        const Result<std::optional<EncoderSample>> sample =
            DecodeHidReport(read.bytes, track_.config().hid);
        if (!sample) {
            track_.Fault(EncoderFault::kShortRead, sample.error().message);
        } else if (*sample) {
            silence.Heard();
            EncoderSample timed = **sample;
            timed.time_s = now_s;
            track_.Add(timed);
        }
    }
    return std::nullopt;
}

}  // namespace flare
