// SPDX-License-Identifier: Apache-2.0
//
// One US Digital QSB at 230400 baud: set to quadrature counts, line ends and time stamps, its
// version asked for, then streaming at its shortest interval (1.9 ms).
#pragma once

#include "server/encoder/encoder_source.h"
#include "server/encoder/line_splitter.h"
#include "server/encoder/qsb.h"
#include "server/encoder/usb_port.h"

namespace flare {

class QsbTalk {
  public:
    QsbTalk(FtdiPort& port, EncoderTrack& track, const StopSignal& stop)
        : port_(port), track_(track), stop_(stop) {}

    // What ended it; nothing if it was to stop.
    std::optional<UsbProblem> Run(const UsbFound& found);

  private:
    std::optional<UsbProblem> Begin(const UsbFound& found);
    std::optional<UsbProblem> Listen();
    void Take(const std::string& line, double now_s);

    FtdiPort& port_;
    EncoderTrack& track_;
    const StopSignal& stop_;
    LineSplitter lines_{64};
    QsbCounter counter_;
};

}  // namespace flare
