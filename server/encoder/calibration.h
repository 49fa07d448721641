// SPDX-License-Identifier: Apache-2.0
//
// Turns the samples of one encoder, in the order of their times, into readings: tables where the
// config has them, what the device itself states where not, then smoothing. Smoothing is an
// exponential mean with time constant smooth_ms in the even variable (axis_table.h): a ring that
// turns evenly is followed smooth_ms late, one that stops is met to 5 % after 3 smooth_ms. Belongs
// to one thread.
#pragma once

#include <array>
#include <optional>

#include "server/encoder/axis_table.h"

namespace flare {

struct AxisCalibration {
    std::optional<AxisTable> table;
    double smooth_ms = 0.0;
};

struct CalibrationTables {
    std::array<AxisCalibration, 3> axes;
    bool iris_is_t_stop = true;  // what the iris table's values are
};

class Calibration {
  public:
    explicit Calibration(CalibrationTables tables) : tables_(std::move(tables)) {}

    // A value that is not above 0, or no number, is left out of the reading.
    LensReading Read(const EncoderSample& sample);
    // After a gap the past does not count.
    void Forget();

  private:
    struct Past {
        double time_s = 0.0, even = 0.0;
    };
    CalibrationTables tables_;
    std::array<std::optional<Past>, 3> past_;
};

}  // namespace flare
