// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/calibration.h"

#include <algorithm>
#include <cmath>

namespace flare {

LensReading Calibration::Read(const EncoderSample& sample) {
    LensReading reading;
    reading.iris_is_t_stop = sample.stated.iris_is_t_stop;
    for (const LensAxis axis : kLensAxes) {
        const AxisCalibration& calibration = tables_.axes[Index(axis)];
        std::optional<double> value = sample.stated[axis];
        if (const std::optional<double>& raw = sample.raw[Index(axis)]; calibration.table && raw) {
            value = calibration.table->Value(*raw);
            if (axis == LensAxis::kIris) reading.iris_is_t_stop = tables_.iris_is_t_stop;
        }
        if (!value || !(*value > 0.0)) continue;
        if (axis != LensAxis::kFocus && !std::isfinite(*value)) continue;
        if (calibration.smooth_ms > 0.0) {
            double even = EvenFromValue(axis, *value);
            if (const std::optional<Past>& past = past_[Index(axis)]) {
                const double dt_ms = 1e3 * std::max(0.0, sample.time_s - past->time_s);
                even =
                    past->even + (even - past->even) * -std::expm1(-dt_ms / calibration.smooth_ms);
            }
            past_[Index(axis)] = Past{sample.time_s, even};
            value = ValueFromEven(axis, even);
        }
        reading[axis] = value;
    }
    return reading;
}

void Calibration::Forget() {
    past_ = {};
}

}  // namespace flare
