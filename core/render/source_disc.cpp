// SPDX-License-Identifier: Apache-2.0
#include "core/render/source_disc.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/render/source_picture.h"

namespace flare {
namespace {

constexpr int kPointsOfWhole = 24;  // along a side of the square
constexpr int kPieces = 10;         // of a part along a side: its light falls in so many steps
constexpr int kPointsOfPiece = 3;
constexpr double kRounding = 1e-12;  // knots no farther apart are one
constexpr double kStep = 0.25;       // of the disc's width, to tell one frame of turns from another

// The concentric map, to the unit disc.
Vec2d OnDisc(double a, double b) {
    if (a == 0.0 && b == 0.0) return {0.0, 0.0};
    const bool wide = std::abs(a) > std::abs(b);
    const double r = wide ? a : b;
    const double angle = wide ? 0.25 * kPi * b / a : 0.5 * kPi - 0.25 * kPi * a / b;
    return {r * std::cos(angle), r * std::sin(angle)};
}

// The image of a rectangle of the square, by so many points a side.
std::vector<Vec2d> ImageOf(const SourceSide::Piece& x, const SourceSide::Piece& y, int points,
                           double radius) {
    std::vector<Vec2d> outline;
    outline.reserve(static_cast<std::size_t>(4 * points));
    const auto side = [&](Vec2d from, Vec2d to) {
        for (int k = 0; k < points; ++k) {
            const Vec2d at = from + (to - from) * (static_cast<double>(k) / points);
            outline.push_back(OnDisc(at.x, at.y) * radius);
        }
    };
    side({x.from, y.from}, {x.to, y.from});
    side({x.to, y.from}, {x.to, y.to});
    side({x.to, y.to}, {x.from, y.to});
    side({x.from, y.to}, {x.from, y.from});
    return outline;
}

}  // namespace

double SourceHat::At(double a) const {
    const double t = (a - node) / reach;
    if ((first && t <= 0.0) || (last && t >= 0.0)) return 1.0;
    return std::max(0.0, 1.0 - std::abs(t));
}

std::vector<SourceSide::Piece> SourceSide::Pieces(int count) const {
    std::array<double, 4> knots{from, std::clamp(outer.node, from, to),
                                std::clamp(inner.node, from, to), to};
    std::sort(knots.begin(), knots.end());
    std::vector<Piece> pieces;
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
        const double length = knots[k + 1] - knots[k];
        if (length < kRounding) continue;
        const int parts = static_cast<int>(std::ceil(length / (to - from) * count));
        for (int i = 0; i < parts; ++i) {
            const double a = knots[k] + length * i / parts;
            const double b = i + 1 == parts ? knots[k + 1] : knots[k] + length * (i + 1) / parts;
            // Simpson's rule is exact: products of two hats are quadratic between knots.
            const double mean = (At(a) + 4.0 * At(0.5 * (a + b)) + At(b)) / 6.0;
            pieces.push_back({a, b, 0.5 * (b - a) * mean});
        }
    }
    return pieces;
}

double SourceSide::MeanOver(double a, double b) const {
    if (whole()) return 1.0;
    const double lo = std::clamp(a, from, to), hi = std::clamp(b, from, to);
    std::array<double, 4> knots{lo, std::clamp(outer.node, lo, hi), std::clamp(inner.node, lo, hi),
                                hi};
    std::sort(knots.begin(), knots.end());
    double sum = 0.0;
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) {
        const double c = knots[k], d = knots[k + 1];
        sum += (d - c) * (At(c) + 4.0 * At(0.5 * (c + d)) + At(d)) / 6.0;
    }
    return sum / (b - a);
}

double SourceSide::share() const {
    if (whole()) return 1.0;
    double sum = 0.0;
    for (const Piece& piece : Pieces(1)) sum += piece.share;
    return sum;
}

SourceSide SourceSide::Part(int i, int n) const {
    if (n == 1) return *this;
    FLARE_CHECK(outer.first && outer.last);
    const double width = (to - from) / n;
    SourceSide part{from, to, inner, {from + (i + 0.5) * width, width, i == 0, i + 1 == n}};
    if (!part.inner.first) part.from = part.inner.node - width;
    if (!part.inner.last) part.to = part.inner.node + width;
    return part;
}

SourceDisc::SourceDisc(const Lens& lens, const PlacedLight& light)
    : lens_(lens), light_(light), bundle_(BundleOf(lens, light)) {
    if (!light.shape) return;
    const UprightAxes axes = UprightAt(light.direction);
    // Turns are lengths of arcs through the light: along them the axes stay what they are.
    const auto turn = [&](const Vec3d& axis) {
        constexpr double kSmall = 1e-3;
        const Vec3d towards = light.direction + axis * kSmall;
        const Vec2d across(-towards.x, -towards.y);
        const Vec2d t = bundle_.TurnTo(
            Vec3d(across.dot(light.pose.x_axis), across.dot(light.pose.y_axis), towards.z)
                .normalized());
        return t * (0.5 * light.angular_diameter_rad / t.length());
    };
    right_ = turn(axes.right);
    up_ = turn(axes.up);
}

double SourceDisc::ShareOf(const SourceSquare& part) const {
    if (!light_.shape) return part.share();
    double share = 0.0;
    for (const SourcePatch& patch : PatchesOfShape(part)) share += patch.share;
    return share;
}

// Cells of the image, those of a row that are alike as one.
std::vector<SourcePatch> SourceDisc::PatchesOfShape(const SourceSquare& part) const {
    const SourcePicture& picture = *light_.shape;
    const int side = picture.side();
    const auto place = [&](int k) { return 2.0 * k / side - 1.0; };
    std::vector<double> across, along;
    for (int k = 0; k < side; ++k) {
        across.push_back(part.x.MeanOver(place(k), place(k + 1)));
        along.push_back(part.y.MeanOver(place(k), place(k + 1)));
    }
    std::vector<SourcePatch> patches;
    for (int j = 0; j < side; ++j) {
        const auto share = [&](int i) {
            return picture.At(i, j) * across[static_cast<std::size_t>(i)] *
                   along[static_cast<std::size_t>(j)];
        };
        for (int i = 0; i < side;) {
            const double of_cell = share(i);
            int end = i + 1;
            while (end < side && share(end) == of_cell) ++end;
            if (of_cell > 0.0) {
                const auto at = [&](int k, int l) { return right_ * place(k) + up_ * place(l); };
                patches.push_back(
                    {{at(i, j), at(end, j), at(end, j + 1), at(i, j + 1)}, of_cell * (end - i)});
            }
            i = end;
        }
    }
    return patches;
}

std::vector<SourcePatch> SourceDisc::PatchesOfDisc(const SourceSquare& part) const {
    double radius = 0.5 * light_.angular_diameter_rad;
    std::vector<SourcePatch> patches;
    if (part.whole()) {
        // Chords cut off some of the disc.
        const double turn = 2.0 * kPi / (4 * kPointsOfWhole);
        radius *= std::sqrt(turn / std::sin(turn));
        patches.push_back({ImageOf({-1.0, 1.0, 1.0}, {-1.0, 1.0, 1.0}, kPointsOfWhole, radius)});
    } else {
        const std::vector<SourceSide::Piece> across = part.x.Pieces(kPieces);
        for (const SourceSide::Piece& y : part.y.Pieces(kPieces)) {
            for (const SourceSide::Piece& x : across) {
                patches.push_back({ImageOf(x, y, kPointsOfPiece, radius), x.share * y.share});
            }
        }
    }
    return patches;
}

SourceCell SourceDisc::OwnCell(const SourceSquare& part, Vec2d& middle) const {
    return CellOfPatches(light_.shape ? PatchesOfShape(part) : PatchesOfDisc(part), middle);
}

Vec3d SourceDisc::Travel(Vec2d turn_rad) const {
    const Vec3d canonical = bundle_.TurnedTravel(turn_rad);
    const Vec2d across = light_.pose.LensSpace({canonical.x, canonical.y});
    return {across.x, across.y, canonical.z};
}

PlacedLight SourceDisc::LightOf(const SourceSquare& part) const {
    if (part.whole() && !light_.shape) return light_;
    Vec2d middle(0.0, 0.0);
    const SourceCell cell = OwnCell(part, middle);
    const Vec3d travel = Travel(middle);
    PlacedLight light = FacedTo(lens_, light_, Vec3d(-travel.x, -travel.y, travel.z));
    const double share = ShareOf(part);
    light.irradiance *= share;
    light.share *= share;
    if (light_.shape) light.detail_rad = light_.shape->detail() * right_.length();
    light.shape = nullptr;
    // A disc's second moment along an axis is a quarter of its radius squared.
    light.angular_diameter_rad = 4.0 * std::sqrt(0.5 * (cell.xx + cell.yy));
    return light;
}

// One frame of turns seen from another is all but affine over a disc of some degrees.
SourceCell SourceDisc::CellOf(const SourceSquare& part, const PlacedLight& seen_from) const {
    Vec2d middle(0.0, 0.0);
    SourceCell cell = OwnCell(part, middle);
    const LightBundle from = BundleOf(lens_, seen_from);
    const auto turn = [&](Vec2d own) {
        const Vec3d travel = Travel(own);
        const Vec2d across(travel.x, travel.y);
        return from.TurnTo(
            Vec3d(across.dot(seen_from.pose.x_axis), across.dot(seen_from.pose.y_axis), travel.z));
    };
    const double step = kStep * light_.angular_diameter_rad;
    const Vec2d u =
        (turn(middle + Vec2d(step, 0.0)) - turn(middle - Vec2d(step, 0.0))) / (2.0 * step);
    const Vec2d v =
        (turn(middle + Vec2d(0.0, step)) - turn(middle - Vec2d(0.0, step))) / (2.0 * step);
    for (SourcePatch& patch : cell.patches) {
        for (Vec2d& p : patch.outline) p = u * p.x + v * p.y;
    }
    return CellOfPatches(std::move(cell.patches), middle);
}

}  // namespace flare
