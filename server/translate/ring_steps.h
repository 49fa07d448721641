// SPDX-License-Identifier: Apache-2.0
//
// The steps to which readings of a lens encoder are rounded where ghost meshes depend on them. A
// mesh belongs to one state of the lens to the last bit, and a ring passes through more of them
// than can be traced; in steps, a state is met again, and can be traced before it is met.
//
// Focus goes in steps of 1/distance that move the image by kImageStep_mm: f^2 d(1/s) (Newton), with
// f the longest focal length. Meshes depend on it if the lens has a table for focus, or if lights
// are placed by pixel, whose directions follow the focus. Zoom goes in steps of its logarithm, of a
// zoom lens alone. The step in which an end of the lens's own table lies stands for that end, so
// that a ring at its stop is not taken for one beyond it. What meshes do not depend on is not
// rounded, and the iris never is. Plain values.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/optics/lens.h"
#include "protocol/wire/flare_request.h"
#include "server/encoder/lens_reading.h"

namespace flare {

inline constexpr double kImageStep_mm = 0.01;
inline constexpr double kZoomStep = 1.0 / 2048.0;  // relative

// A state in steps: of focus (0 is infinity) and of zoom; 0 also for what is not rounded.
struct RingCell {
    std::int64_t focus = 0, zoom = 0;

    friend bool operator==(const RingCell&, const RingCell&) = default;
};

class RingSteps {
  public:
    static RingSteps For(const Lens& lens, const wire::FlareRequest& request);

    // False: nothing is rounded.
    bool any() const { return focus_per_m_ > 0.0 || zoom_ > 0.0; }
    double focus_per_m() const { return focus_per_m_; }  // in 1/m; 0: not rounded

    RingCell CellOf(const LensReading& reading) const;
    // The reading with the values of the cell in place of those that it has and that are rounded.
    LensReading Put(RingCell cell, LensReading reading) const;
    LensReading Rounded(const LensReading& reading) const { return Put(CellOf(reading), reading); }

  private:
    std::int64_t FocusCell(double focus_m) const;
    std::int64_t ZoomCell(double zoom_mm) const;

    double focus_per_m_ = 0.0, zoom_ = 0.0;
    std::optional<double> nearest_m_;                // of a table of focus
    std::optional<std::array<double, 2>> zooms_mm_;  // of a zoom lens: both ends
};

}  // namespace flare
