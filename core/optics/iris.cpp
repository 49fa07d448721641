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

// A number in -1..1 (SplitMix64).
double Share(std::uint64_t seed, std::uint64_t index) {
    std::uint64_t z = seed + (index + 1) * 0x9E3779B97F4A7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    z ^= z >> 31;
    return static_cast<double>(z >> 11) * 0x1.0p-52 - 1.0;
}

// At full irregularity: of a blade's distance, and of half the angle between blades.
constexpr double kOffsetVaries = 0.15;
constexpr double kAngleVaries = 1.0 / 3.0;

}  // namespace

Iris::Iris(const IrisShape& shape, double opening_semi_diameter_mm, double rim_semi_diameter_mm) {
    FLARE_CHECK(opening_semi_diameter_mm > 0.0 && rim_semi_diameter_mm > 0.0);
    const double rim = rim_semi_diameter_mm;
    const Edge rim_edge{{0.0, 0.0}, 0.0, {0.0, 0.0}, rim};
    if (shape.mask && shape.mask_scale == MaskScale::kArea) {
        SetMask(shape, opening_semi_diameter_mm, rim);
        return;
    }
    if (shape.blades == 0) {
        const double radius = std::min(opening_semi_diameter_mm, rim);
        edges_.push_back({{0.0, 0.0}, 0.0, {0.0, 0.0}, radius});
        outer_radius_ = inner_radius_ = radius;
        area_mm2_ = kPi * radius * radius;
    } else {
        FLARE_CHECK(shape.blades >= 3);
        if (shape.irregularity > 0.0) {
            SetIrregularBlades(shape, opening_semi_diameter_mm);
        } else {
            SetBlades(shape, opening_semi_diameter_mm);
        }
        const bool rim_cuts = outer_radius_ > rim;
        outer_radius_ = std::min(outer_radius_, rim);
        inner_radius_ = std::min(inner_radius_, rim);
        if (rim_cuts) {
            edges_.push_back(rim_edge);
            rim_cuts_ = true;
        }
    }
    edges_inner_radius_ = inner_radius_;
    if (!shape.mask) return;
    picture_ = shape.mask->Placed(rim * shape.mask->half_width_mm(),
                                  RadiansFromDegrees(shape.rotation_deg));
    outer_radius_ = std::min(outer_radius_, picture_->outer_radius());
    inner_radius_ = std::min(inner_radius_, picture_->clear_radius());
}

void Iris::SetBlades(const IrisShape& shape, double opening_semi_diameter_mm) {
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
    outer_radius_ = circumradius;
    inner_radius_ = circumradius * (unit.apothem + unit.sagitta);
    area_mm2_ = circumradius * circumradius * unit.area;
}

// Blades of the regular iris, moved and turned; then all is scaled to the area.
void Iris::SetIrregularBlades(const IrisShape& shape, double opening_semi_diameter_mm) {
    SetBlades(shape, 1.0);
    const double amount = std::clamp(shape.irregularity, 0.0, 1.0);
    for (std::size_t k = 0; k < edges_.size(); ++k) {
        Edge& edge = edges_[k];
        const double out = 1.0 + kOffsetVaries * amount * Share(shape.seed, 2 * k);
        const double turn =
            kAngleVaries * amount * kPi / shape.blades * Share(shape.seed, 2 * k + 1);
        const double c = std::cos(turn);
        const double s = std::sin(turn);
        const double bulge = edge.radius > 0.0 ? edge.centre.dot(edge.normal) + edge.radius : 0.0;
        edge.normal = {edge.normal.x * c - edge.normal.y * s,
                       edge.normal.x * s + edge.normal.y * c};
        edge.offset *= out;
        if (edge.radius > 0.0) edge.centre = edge.normal * (bulge * out - edge.radius);
    }
    constexpr int kSteps = 1 << 15;
    const double scale = opening_semi_diameter_mm * std::sqrt(kPi / RadialArea(kSteps));
    double reach = 0.0;
    inner_radius_ = 1e300;
    for (Edge& edge : edges_) {
        edge.offset *= scale;
        edge.centre *= scale;
        edge.radius *= scale;
        inner_radius_ = std::min(
            inner_radius_, edge.radius > 0.0 ? edge.radius - edge.centre.length() : edge.offset);
    }
    for (int i = 0; i < kSteps; ++i) {
        const double phi = 2.0 * kPi * (i + 0.5) / kSteps;
        reach = std::max(reach, Reach({std::cos(phi), std::sin(phi)}));
    }
    // A corner between two directions reaches farther than both.
    outer_radius_ = reach * (1.0 + 1e-3);
    area_mm2_ = kPi * opening_semi_diameter_mm * opening_semi_diameter_mm;
}

void Iris::SetMask(const IrisShape& shape, double opening_semi_diameter_mm, double rim) {
    const StopPicture& mask = *shape.mask;
    FLARE_CHECK(mask.area_mm2() > 0.0);
    const double size = opening_semi_diameter_mm * std::sqrt(kPi / mask.area_mm2());
    picture_ = mask.Placed(mask.half_width_mm() * size, RadiansFromDegrees(shape.rotation_deg));
    const double radius = std::min(rim, picture_->outer_radius());
    edges_.push_back({{0.0, 0.0}, 0.0, {0.0, 0.0}, radius});
    outer_radius_ = edges_inner_radius_ = radius;
    inner_radius_ = std::min(radius, picture_->clear_radius());
}

Iris Iris::Widened(double dark_mm, double lit_mm) const {
    Iris wide = *this;
    wide.outer_radius_ += dark_mm;
    wide.inner_radius_ = std::max(0.0, wide.inner_radius_ - lit_mm);
    wide.reach_mm_ = dark_mm;
    return wide;
}

// How far the edges let the opening reach from the centre.
double Iris::Reach(Vec2d direction) const {
    double reach = 1e300;
    for (const Edge& edge : edges_) {
        if (edge.radius > 0.0) {
            // |t d - c| = r, the farther of both.
            const double along = edge.centre.dot(direction);
            const double rest = edge.radius * edge.radius - edge.centre.length2();
            reach = std::min(reach, along + std::sqrt(std::max(0.0, along * along + rest)));
        } else if (const double ahead = direction.dot(edge.normal); ahead > 0.0) {
            reach = std::min(reach, edge.offset / ahead);
        }
    }
    return reach;
}

// The edges' opening by its reach in all directions, which is that of every point of it: an
// intersection of discs and half-planes around the centre.
double Iris::RadialArea(int steps) const {
    double sum = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double phi = 2.0 * kPi * (i + 0.5) / steps;
        const double reach = Reach({std::cos(phi), std::sin(phi)});
        sum += reach * reach;
    }
    return kPi * sum / steps;
}

double Iris::area_mm2() const {
    if (picture_) {
        // By the cells of a lattice over the disc around it.
        constexpr int kSide = 1500;
        const double step = 2.0 * outer_radius_ / kSide;
        double sum = 0.0;
        for (int j = 0; j < kSide; ++j) {
            for (int i = 0; i < kSide; ++i) {
                sum += TransmissionAt(
                    {(i + 0.5) * step - outer_radius_, (j + 0.5) * step - outer_radius_});
            }
        }
        return sum * step * step;
    }
    return rim_cuts_ ? RadialArea(1 << 14) : area_mm2_;
}

double Iris::TransmissionAt(Vec2d p) const {
    if (Distance(p) > 0.0) return 0.0;
    return picture_ ? picture_->At(p) : 1.0;
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
