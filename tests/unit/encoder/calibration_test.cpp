// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace flare {
namespace {

EncoderSample Stated(double time_s, double focus_m) {
    EncoderSample sample;
    sample.time_s = time_s;
    sample.stated[LensAxis::kFocus] = focus_m;
    return sample;
}

TEST(Calibration, PrefersTheTableToWhatTheDeviceStates) {
    CalibrationTables tables;
    tables.axes[0].table = *AxisTable::Build(LensAxis::kFocus, {{0, 10}, {1, 2}});
    tables.axes[1].table = *AxisTable::Build(LensAxis::kIris, {{0, 10}, {2, 8}});
    tables.iris_is_t_stop = false;
    Calibration calibration(tables);
    EncoderSample sample;
    sample.raw = {10.0, 5.0, std::nullopt};
    sample.stated.values = {9.0, 9.0, 35.0};
    sample.stated.iris_is_t_stop = true;
    const LensReading reading = calibration.Read(sample);
    EXPECT_EQ(reading[LensAxis::kFocus], 2.0);
    EXPECT_NEAR(*reading[LensAxis::kIris], 4.0, 1e-12);
    EXPECT_FALSE(reading.iris_is_t_stop);
    EXPECT_EQ(reading[LensAxis::kZoom], 35.0);
}

TEST(Calibration, LeavesOutWhatIsNoState) {
    Calibration calibration{CalibrationTables{}};
    EncoderSample sample;
    sample.stated.values = {0.0, std::numeric_limits<double>::infinity(), std::nan("")};
    EXPECT_EQ(calibration.Read(sample), LensReading{});
    sample.stated.values = {std::numeric_limits<double>::infinity(), -1.0, std::nullopt};
    EXPECT_TRUE(calibration.Read(sample)[LensAxis::kFocus].has_value());
    EXPECT_FALSE(calibration.Read(sample)[LensAxis::kIris].has_value());
}

// The closed form of an exponential mean: a step is met as 1 - exp(-t/tau), an even turn is
// followed tau late.
TEST(Calibration, SmoothsWithItsTimeConstantInTheEvenVariable) {
    CalibrationTables tables;
    tables.axes[0].smooth_ms = 40.0;
    Calibration calibration(tables);
    calibration.Read(Stated(0.0, std::numeric_limits<double>::infinity()));
    LensReading reading;
    for (int i = 1; i <= 120; ++i) reading = calibration.Read(Stated(1e-3 * i, 0.5));
    EXPECT_NEAR(1.0 / *reading[LensAxis::kFocus], 2.0 * (1.0 - std::exp(-3.0)), 1e-9);
    calibration.Forget();
    EXPECT_NEAR(*calibration.Read(Stated(1.0, 3.0))[LensAxis::kFocus], 3.0, 1e-12);
    for (int i = 1; i <= 1000; ++i) {
        reading = calibration.Read(Stated(1.0 + 1e-3 * i, 1.0 / (1.0 / 3.0 + 1e-3 * i)));
    }
    // 1/m rises by 1 a second: 40 ms late is 0.04 behind, give or take half a sample.
    EXPECT_NEAR(1.0 / *reading[LensAxis::kFocus], 1.0 / 3.0 + 1.0 - 0.04, 6e-4);
}

}  // namespace
}  // namespace flare
