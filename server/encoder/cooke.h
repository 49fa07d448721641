// SPDX-License-Identifier: Apache-2.0
//
// What a Cooke /i lens says over its serial line, without the line's end (LF CR). Source: Cooke /i
// user's guide and technical manual 3.0 (2012), chapter 5. Distances are in the lens's display
// units, 1 mm or 0.1 inch; the fixed data say which.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace flare {

// The two letters of checksum mode (command G): the exclusive or of all bytes, from FF on, in two
// halves, each with 40 added. "B 5.03" has "HE".
std::array<char, 2> CookeChecksum(std::string_view text);
// The text without its two letters. Error code "bad_data".
Result<std::string_view> CheckCookeChecksum(std::string_view line);

// The answer to N.
struct CookeLens {
    std::string serial, owner;
    bool zoom = false;
    int focal_mm = 0, longest_focal_mm = 0;  // equal for a prime
    bool imperial = false;                   // display units
};
Result<CookeLens> DecodeCookeLens(std::string_view line);

// What D (and C) and Kd (and Kc) give of the lens's state.
struct CookeRecord {
    double focus = 0.0;  // in display units; infinity is a value
    double t_stop = 0.0;
    int zoom_mm = 0;  // 0: a prime
    std::string serial;
};
Result<CookeRecord> DecodeCookeText(std::string_view line);    // "D0000402T0195..."
Result<CookeRecord> DecodeCookePacked(std::string_view line);  // "d@@O}CC..."

double CookeFocus_m(const CookeRecord& record, bool imperial);

}  // namespace flare
