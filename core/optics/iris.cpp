// SPDX-License-Identifier: Apache-2.0
#include "core/optics/iris.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/units.h"

namespace flare {
namespace {

// A regular polygon of circumradius 1 whose sides bulge by `roundness` of the circle's sagitta.
struct UnitShape {
    double apothem, sagitta, arc_radius, area;
};

UnitShape ShapeOf(int blades, double roundness) {
    const double half_angle = kPi / blades;
    const double half_chord = std::sin(half_angle);
    const double apothem = std::cos(half_angle);
    const double sagitta = roundness * (1.0 - apothem);
    double area = blades * half_chord * apothem;
    double arc_radius = 0.0;
    if (sagitta > 0.0) {
        arc_radius = (half_chord * half_chord + sagitta * sagitta) / (2.0 * sagitta);
        const double half_arc = std::asin(std::min(1.0, half_chord / arc_radius));
        area +=
            blades * arc_radius * arc_radius * (half_arc - std::sin(half_arc) * std::cos(half_arc));
    }
    return {apothem, sagitta, arc_radius, area};
}

}  // namespace

Iris::Iris(const IrisShape& shape, double opening_semi_diameter_mm, double rim_semi_diameter_mm) {
    FLARE_CHECK(opening_semi_diameter_mm > 0.0 && rim_semi_diameter_mm > 0.0);
    const double rim = rim_semi_diameter_mm;
    const Edge rim_edge{{0.0, 0.0}, 0.0, {0.0, 0.0}, rim};
    if (shape.blades == 0) {
        const double radius = std::min(opening_semi_diameter_mm, rim);
        edges_.push_back({{0.0, 0.0}, 0.0, {0.0, 0.0}, radius});
        outer_radius_ = inner_radius_ = radius;
        area_mm2_ = kPi * radius * radius;
        return;
    }
    FLARE_CHECK(shape.blades >= 3);
    const UnitShape unit = ShapeOf(shape.blades, std::clamp(shape.roundness, 0.0, 1.0));
    const double circumradius = opening_semi_diameter_mm * std::sqrt(kPi / unit.area);
    for (int k = 0; k < shape.blades; ++k) {
        // Corner k stands at +y turned by k steps; edge k joins corners k and k + 1.
        const double angle = kPi / 2.0 + RadiansFromDegrees(shape.rotation_deg) +
                             (2.0 * k + 1.0) * kPi / shape.blades;
        Edge edge;
        edge.normal = {std::cos(angle), std::sin(angle)};
        edge.offset = circumradius * unit.apothem;
        if (unit.arc_radius > 0.0) {
            edge.radius = circumradius * unit.arc_radius;
            edge.centre =
                edge.normal * (circumradius * (unit.apothem + unit.sagitta) - edge.radius);
        }
        edges_.push_back(edge);
    }
    outer_radius_ = std::min(circumradius, rim);
    inner_radius_ = std::min(circumradius * (unit.apothem + unit.sagitta), rim);
    area_mm2_ = circumradius * circumradius * unit.area;
    if (circumradius <= rim) return;

    edges_.push_back(rim_edge);
    rim_cuts_ = true;
}

// Where the rim cuts corners off, the area is that of the radius function, capped.
double Iris::area_mm2() const {
    if (!rim_cuts_) return area_mm2_;
    constexpr int kSteps = 1 << 14;
    double sum = 0.0;
    for (int i = 0; i < kSteps; ++i) {
        const double phi = 2.0 * kPi * (i + 0.5) / kSteps;
        const Vec2d u(std::cos(phi), std::sin(phi));
        double lo = 0.0;
        double hi = outer_radius_;
        for (int step = 0; step < 45; ++step) {
            const double mid = 0.5 * (lo + hi);
            (Distance(u * mid) <= 0.0 ? lo : hi) = mid;
        }
        sum += lo * lo;
    }
    return kPi * sum / kSteps;
}

double Iris::EdgeDistance(int k, Vec2d p) const {
    const Edge& edge = edges_[static_cast<std::size_t>(k)];
    if (edge.radius > 0.0) return (p - edge.centre).length() - edge.radius;
    return p.dot(edge.normal) - edge.offset;
}

double Iris::Distance(Vec2d p) const {
    double largest = EdgeDistance(0, p);
    for (int k = 1; k < edge_count(); ++k) largest = std::max(largest, EdgeDistance(k, p));
    return largest;
}

}  // namespace flare
