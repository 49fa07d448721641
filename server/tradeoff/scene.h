// SPDX-License-Identifier: Apache-2.0
//
// A picture that a sweep is measured on: one lens at one opening, one white light at infinity at a
// field angle, turned by 20 degrees about the axis; the frame is 36 mm wide.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/fingerprint.h"
#include "core/render/flare_request.h"
#include "server/tradeoff/trial.h"

namespace flare {

struct TradeoffScene {
    std::string lens_name;
    std::string coatings = "own";  // "own", or the name of one for every surface
    std::shared_ptr<const Lens> lens;
    double f_number = 0.0, field_deg = 0.0;
    int width = 0, height = 0;

    FlareRequest Request() const;
    // Names the reference picture.
    Fingerprint Key(Truth truth) const;
    std::string name() const;
};

inline constexpr double kTradeoffSensor_mm = 36.0;

// The openings, but none wider than the lens's own, and no angle twice. Without angles: 0.2, 0.6
// and 1 of the angle of the frame's right edge.
std::vector<TradeoffScene> ScenesOf(const TradeoffScene& base, const std::vector<double>& f_numbers,
                                    const std::vector<double>& field_deg);

}  // namespace flare
