// SPDX-License-Identifier: Apache-2.0
//
// From the counts of one ring to its value: a table of the lens's marks. A count is first brought
// to the table's scale, r = count - zero, turned round for a ring that counts the other way, and,
// for an encoder that begins anew after `wrap` counts, put into the turn whose middle is that of
// the table. Between marks the value follows a monotone cubic (Fritsch & Carlson 1980) over r in
// the variable in which a ring is roughly even: 1/distance for focus, the logarithm for stops and
// focal lengths. At a mark the value is the mark's to the last bit; beyond the ends it is held.
// Immutable, safe from any thread.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "server/encoder/lens_reading.h"

namespace flare {

// The even variable of an axis: 1/m for focus (0 at infinity), log2 for iris and zoom.
double EvenFromValue(LensAxis axis, double value);
double ValueFromEven(LensAxis axis, double even);

struct AxisMarks {
    std::vector<double> raw;    // at least two, all different, in any order
    std::vector<double> value;  // one for each raw; rising or falling with it
    double zero = 0.0;
    bool reverse = false;
    double wrap = 0.0;  // 0: the count does not wrap
};

class AxisTable {
  public:
    // Error code "bad_value"; `where` is "raw", "value" or "wrap".
    static Result<AxisTable> Build(LensAxis axis, const AxisMarks& marks);

    double Value(double count) const;

  private:
    LensAxis axis_ = LensAxis::kFocus;
    double zero_ = 0.0, sign_ = 1.0, wrap_ = 0.0, middle_ = 0.0;
    std::vector<double> raw_, value_, even_;  // by rising raw
};

}  // namespace flare
