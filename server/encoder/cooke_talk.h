// SPDX-License-Identifier: Apache-2.0
//
// One Cooke /i lens: found at 115200 or 9600 baud by the command N, brought to 230400 (Kb7) where
// it can, set to checksums (G) and to packed records without end (Kc); at the end it is told to
// stop (H).
#pragma once

#include <string>

#include "server/encoder/cooke.h"
#include "server/encoder/encoder_source.h"
#include "server/encoder/line_splitter.h"
#include "server/encoder/usb_port.h"

namespace flare {

class CookeTalk {
  public:
    CookeTalk(FtdiPort& port, EncoderTrack& track, const StopSignal& stop)
        : port_(port), track_(track), stop_(stop) {}

    // What ended it; nothing if it was to stop.
    std::optional<UsbProblem> Run(const UsbFound& found);

  private:
    struct Answer {
        std::string line;  // "": none came
        std::optional<UsbProblem> problem;
    };
    // Sends a command and waits for the first line that `begins` so.
    Answer Ask(std::string_view command, std::string_view begins);
    std::optional<UsbProblem> Meet(CookeLens& lens);
    std::optional<UsbProblem> SpeedUp();
    std::optional<UsbProblem> Listen();
    void Take(std::string_view line, double now_s);

    FtdiPort& port_;
    EncoderTrack& track_;
    const StopSignal& stop_;
    LineSplitter lines_{128};
    int baud_ = 0;
    bool imperial_ = false;
};

}  // namespace flare
