// SPDX-License-Identifier: Apache-2.0
//
// What a lens encoder says: the counts of its rings as they come (`EncoderSample`), and the lens
// state they mean (`LensReading`). Every value is optional, for few devices measure all three.
// Times are Unix seconds of EncoderClock. Plain values.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string_view>

namespace flare {

// The three rings of a lens, in the order of every array here.
enum class LensAxis { kFocus, kIris, kZoom };
inline constexpr std::array kLensAxes{LensAxis::kFocus, LensAxis::kIris, LensAxis::kZoom};
inline constexpr std::array<std::string_view, 3> kLensAxisNames{"focus", "iris", "zoom"};
constexpr std::size_t Index(LensAxis axis) {
    return static_cast<std::size_t>(axis);
}
constexpr std::string_view Name(LensAxis axis) {
    return kLensAxisNames[Index(axis)];
}

struct LensReading {
    // Focus distance from the sensor in m (infinity is a value), T- or f-stop, focal length in mm.
    // All above 0.
    std::array<std::optional<double>, 3> values;
    bool iris_is_t_stop = false;

    const std::optional<double>& operator[](LensAxis axis) const { return values[Index(axis)]; }
    std::optional<double>& operator[](LensAxis axis) { return values[Index(axis)]; }
    friend bool operator==(const LensReading&, const LensReading&) = default;
};

struct EncoderSample {
    double time_s = 0.0;
    std::array<std::optional<double>, 3> raw;  // in the device's own counts
    LensReading stated;                        // what the device itself gives as a lens state
};

// The seconds of the system's clock at the start of the program, counted on by a steady one: a
// clock that is set does not bend the history.
class EncoderClock {
  public:
    static double Now_s();
};

}  // namespace flare
