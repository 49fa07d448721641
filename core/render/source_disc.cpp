// SPDX-License-Identifier: Apache-2.0
#include "core/render/source_disc.h"

#include <cmath>

#include "core/base/units.h"

namespace flare {
namespace {

constexpr int kPointsOfSide = 24;

// The concentric map, to the unit disc.
Vec2d OnDisc(double a, double b) {
    if (a == 0.0 && b == 0.0) return {0.0, 0.0};
    const bool wide = std::abs(a) > std::abs(b);
    const double r = wide ? a : b;
    const double angle = wide ? 0.25 * kPi * b / a : 0.5 * kPi - 0.25 * kPi * a / b;
    return {r * std::cos(angle), r * std::sin(angle)};
}

}  // namespace

SourceSquare SourceSquare::Part(int i, int j, int n) const {
    const double dx = (x1 - x0) / n;
    const double dy = (y1 - y0) / n;
    return {i == 0 ? x0 : x0 + i * dx, i + 1 == n ? x1 : x0 + (i + 1) * dx,
            j == 0 ? y0 : y0 + j * dy, j + 1 == n ? y1 : y0 + (j + 1) * dy};
}

SourceDisc::SourceDisc(const Lens& lens, const PlacedLight& light)
    : lens_(lens), light_(light), bundle_(BundleOf(lens, light)) {}

// Of the part's own area: chords cut off some of the disc.
std::vector<Vec2d> SourceDisc::Outline(const SourceSquare& part) const {
    const double radius = 0.5 * light_.angular_diameter_rad;
    std::vector<Vec2d> points;
    const auto side = [&](Vec2d from, Vec2d to) {
        for (int k = 0; k < kPointsOfSide; ++k) {
            const Vec2d at = from + (to - from) * (static_cast<double>(k) / kPointsOfSide);
            points.push_back(OnDisc(at.x, at.y) * radius);
        }
    };
    side({part.x0, part.y0}, {part.x1, part.y0});
    side({part.x1, part.y0}, {part.x1, part.y1});
    side({part.x1, part.y1}, {part.x0, part.y1});
    side({part.x0, part.y1}, {part.x0, part.y0});
    double area = 0.0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const Vec2d& next = points[(k + 1) % points.size()];
        area += 0.5 * (points[k].x * next.y - points[k].y * next.x);
    }
    Vec2d middle(0.0, 0.0);
    for (const Vec2d& p : points) middle += p / static_cast<double>(points.size());
    const double grow = std::sqrt(part.share() * kPi * radius * radius / area);
    for (Vec2d& p : points) p = middle + (p - middle) * grow;
    return points;
}

Vec3d SourceDisc::Travel(Vec2d turn_rad) const {
    const Vec3d canonical = bundle_.TurnedTravel(turn_rad);
    const Vec2d across = light_.pose.LensSpace({canonical.x, canonical.y});
    return {across.x, across.y, canonical.z};
}

PlacedLight SourceDisc::LightOf(const SourceSquare& part) const {
    if (part.whole()) return light_;
    Vec2d middle(0.0, 0.0);
    CellOfOutline(Outline(part), middle);
    const Vec3d travel = Travel(middle);
    PlacedLight light = FacedTo(lens_, light_, Vec3d(-travel.x, -travel.y, travel.z));
    light.irradiance *= part.share();
    light.share *= part.share();
    light.angular_diameter_rad *= std::sqrt(part.share());
    return light;
}

SourceCell SourceDisc::CellOf(const SourceSquare& part, const PlacedLight& seen_from) const {
    std::vector<Vec2d> outline = Outline(part);
    const LightBundle from = BundleOf(lens_, seen_from);
    for (Vec2d& p : outline) {
        const Vec3d travel = Travel(p);
        const Vec2d across(travel.x, travel.y);
        p = from.TurnTo(
            Vec3d(across.dot(seen_from.pose.x_axis), across.dot(seen_from.pose.y_axis), travel.z));
    }
    Vec2d middle(0.0, 0.0);
    return CellOfOutline(std::move(outline), middle);
}

}  // namespace flare
