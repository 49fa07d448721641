// SPDX-License-Identifier: Apache-2.0
#include "server/tradeoff/scene.h"

#include <algorithm>
#include <cmath>

#include "core/base/units.h"
#include "server/tradeoff/number_text.h"

namespace flare {
namespace {

constexpr double kTurn_deg = 20.0;
constexpr int kKeyVersion = 1;  // grows when the same scene is drawn otherwise
constexpr double kAngleShares[] = {0.2, 0.6, 1.0};

void AddOnce(double value, std::vector<double>& values) {
    if (std::find(values.begin(), values.end(), value) == values.end()) values.push_back(value);
}

}  // namespace

FlareRequest TradeoffScene::Request() const {
    FlareRequest request;
    request.lens = lens;
    request.f_number = f_number;
    request.image.width = width;
    request.image.height = height;
    request.image.sensor_width_mm = kTradeoffSensor_mm;
    LightSpec light;
    const double field = RadiansFromDegrees(field_deg), turn = RadiansFromDegrees(kTurn_deg);
    light.direction =
        Vec3d(-std::sin(field) * std::cos(turn), std::sin(field) * std::sin(turn), std::cos(field));
    request.lights.push_back(light);
    return request;
}

Fingerprint TradeoffScene::Key(Truth truth) const {
    Fingerprinter hash;
    hash.Add(kKeyVersion).Add(lens->fingerprint()).Add(f_number).Add(field_deg);
    hash.Add(width).Add(height).Add(TruthName(truth));
    return hash.value();
}

std::string TradeoffScene::name() const {
    return lens_name + (coatings == "own" ? "" : " (" + coatings + ")") + " f/" +
           NumberText(f_number) + " " + NumberText(field_deg) + " deg";
}

std::vector<TradeoffScene> ScenesOf(const TradeoffScene& base, const std::vector<double>& f_numbers,
                                    const std::vector<double>& field_deg) {
    std::vector<double> openings, angles = field_deg;
    // To three digits, as it will be read.
    const double widest = std::ceil(100.0 * base.lens->f_number() - 1e-6) / 100.0;
    for (const double f_number : f_numbers) AddOnce(std::max(f_number, widest), openings);
    if (angles.empty()) {
        const double edge = DegreesFromRadians(std::atan(
            0.5 * kTradeoffSensor_mm / std::abs(base.lens->first_order(Section::kX).efl_mm)));
        for (const double share : kAngleShares) {
            AddOnce(std::round(10.0 * share * edge) / 10.0, angles);
        }
    }
    std::vector<TradeoffScene> scenes;
    for (const double f_number : openings) {
        for (const double angle : angles) {
            scenes.push_back(base);
            scenes.back().f_number = f_number;
            scenes.back().field_deg = angle;
        }
    }
    return scenes;
}

}  // namespace flare
