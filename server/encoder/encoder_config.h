// SPDX-License-Identifier: Apache-2.0
//
// One encoder as the configuration describes it (docs/encoders.md). Which fields count depends on
// the kind; the reader of the configuration refuses the others. Plain values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "server/encoder/calibration.h"
#include "server/encoder/hid_report.h"

namespace flare {

enum class EncoderKind { kScript, kFreeD, kOpenTrackIo, kQsb, kCooke, kHid };
inline constexpr std::array<std::string_view, 6> kEncoderKindNames{"script", "freed", "opentrackio",
                                                                   "qsb",    "cooke", "hid"};
constexpr std::string_view Name(EncoderKind kind) {
    return kEncoderKindNames[static_cast<std::size_t>(kind)];
}

struct EncoderConfig {
    std::string name;
    EncoderKind kind = EncoderKind::kScript;
    std::string lens;         // for requests that name none; "": as the device says
    double stale_ms = 500.0;  // without a sample for so long its state is stale
    CalibrationTables calibration;

    std::string file;  // script
    bool loop = false;

    std::string address = "0.0.0.0";  // freed, opentrackio
    std::string multicast;            // group to join; "": none
    int port = 0;
    std::optional<int> source;  // FreeD's camera id; the others of that port are passed over

    std::optional<int> vendor, product;  // qsb, cooke, hid: USB ids
    std::string serial;                  // and serial number; "": any
    LensAxis axis = LensAxis::kFocus;    // qsb: the ring it sits on
    std::optional<int> index_count;  // qsb: the count at the index mark; none: it is passed over
    HidMap hid;
};

}  // namespace flare
