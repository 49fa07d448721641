// SPDX-License-Identifier: Apache-2.0
//
// The counts of a HID input report by a map of fields from the configuration.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/result.h"
#include "server/encoder/lens_reading.h"

namespace flare {

// Where a count stands. Byte 0 is the first that the device sends: the report's id, if it has ids.
struct HidField {
    int byte = 0;
    int bits = 16;  // 8, 16, 24 or 32
    bool is_signed = false;
    bool big_endian = false;
};

struct HidMap {
    std::optional<int> report;  // takes reports with this id alone
    std::array<std::optional<HidField>, 3> fields;
};

// Nothing if the report has another id. Error code "bad_data" if it is too short.
Result<std::optional<EncoderSample>> DecodeHidReport(std::span<const std::uint8_t> report,
                                                     const HidMap& map);

}  // namespace flare
