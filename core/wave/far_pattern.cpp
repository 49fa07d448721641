// SPDX-License-Identifier: Apache-2.0
//
// Of a spike only its profile across is tabulated, wavelengths summed: along it all wavelengths
// fall off alike. Of arcs the edge's length per angle of its normal is kept for some radii.
// Rejected: a Fourier transform of everything. A frame at f/2 is forty thousand fringes wide.
#include "core/wave/far_pattern.h"

#include <algorithm>
#include <cmath>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/wave/coverage.h"

namespace flare {
namespace {

constexpr int kAngles = 1024;  // over half a turn; the pattern is the same on both sides
constexpr double kRingStep = 1.4142135623730951;
// Turn times length times wavenumber below which a side counts as straight.
constexpr double kStraight = 4.0;
// Fresnel's transition at the end of an arc, about as wide as this error function's.
constexpr double kArcEnd = 0.42;

Vec2d Normal(Vec2d tangent) {
    return {tangent.y, -tangent.x};
}

double TurnFrom(Vec2d a, Vec2d b) {
    return std::atan2(a.x * b.y - a.y * b.x, a.dot(b));
}

// Integral of sinc^2 from 0 to x.
class SincSquared {
  public:
    SincSquared() {
        // Simpson's rule over steps of kStep.
        const auto f = [](double x) {
            if (x == 0.0) return 1.0;
            const double s = std::sin(kPi * x) / (kPi * x);
            return s * s;
        };
        sums_.push_back(0.0);
        for (int i = 0; i < kSteps; ++i) {
            const double x = i * kStep;
            sums_.push_back(sums_.back() +
                            kStep / 6.0 * (f(x) + 4.0 * f(x + 0.5 * kStep) + f(x + kStep)));
        }
    }
    double Integral(double x) const {
        const double size = std::abs(x);
        double value = 0.0;
        if (size >= kSteps * kStep) {
            value = 0.5 - 0.5 / (kPi * kPi * size) +
                    std::sin(2.0 * kPi * size) / (4.0 * kPi * kPi * kPi * size * size);
        } else {
            const double at = size / kStep;
            const auto i = static_cast<std::size_t>(at);
            const double t = at - static_cast<double>(i);
            value = sums_[i] * (1.0 - t) + sums_[i + 1] * t;
        }
        return x < 0.0 ? -value : value;
    }

  private:
    static constexpr int kSteps = 4000;
    static constexpr double kStep = 0.01;
    std::vector<double> sums_;
};

// Running sums of a table of means over cells.
std::vector<Vec3d> Summed(const std::vector<Vec3d>& cells) {
    std::vector<Vec3d> sums(cells.size() + 1, Vec3d(0.0, 0.0, 0.0));
    for (std::size_t i = 0; i < cells.size(); ++i) sums[i + 1] = sums[i] + cells[i];
    return sums;
}

// A running sum between two of its entries; beyond its ends as at them.
Vec3d SumAt(const std::vector<Vec3d>& sums, double at) {
    const double last = static_cast<double>(sums.size() - 1);
    if (at >= last) return sums.back();
    const double inside = std::max(at, 0.0);
    const auto i = static_cast<std::size_t>(inside);
    const double t = inside - static_cast<double>(i);
    return sums[i] * (1.0 - t) + sums[i + 1] * t;
}

// The cells' mean over a window of `half` cells to each side.
std::vector<Vec3d> BoxMean(const std::vector<Vec3d>& cells, double half) {
    if (half < 0.5) return cells;
    const std::vector<Vec3d> sums = Summed(cells);
    std::vector<Vec3d> out(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const double middle = static_cast<double>(i) + 0.5;
        out[i] = (SumAt(sums, middle + half) - SumAt(sums, middle - half)) / (2.0 * half);
    }
    return out;
}

// The cells' mean over the chord lengths of a disc seen from the side.
std::vector<Vec3d> DiscMean(const std::vector<Vec3d>& cells, double half) {
    if (half < 0.5) return cells;
    const int reach = static_cast<int>(half + 0.5) + 1;
    const auto below = [&](double x) {
        const double t = std::clamp(x / half, -1.0, 1.0);
        return 0.5 + (t * std::sqrt(1.0 - t * t) + std::asin(t)) / kPi;
    };
    std::vector<double> weights;
    for (int k = -reach; k <= reach; ++k) weights.push_back(below(k + 0.5) - below(k - 0.5));
    std::vector<Vec3d> out(cells.size(), Vec3d(0.0, 0.0, 0.0));
    const int count = static_cast<int>(cells.size());
    for (int i = 0; i < count; ++i) {
        for (int k = -reach; k <= reach; ++k) {
            const int from = std::clamp(i + k, 0, count - 1);
            out[static_cast<std::size_t>(i)] += cells[static_cast<std::size_t>(from)] *
                                                weights[static_cast<std::size_t>(k + reach)];
        }
    }
    return out;
}

}  // namespace

double SourceEllipse::HalfWidth(Vec2d direction) const {
    return std::hypot(a.dot(direction), b.dot(direction));
}

double SourceEllipse::radius() const {
    return std::hypot(a.length(), b.length());
}

FarPattern::FarPattern(const std::vector<ApertureOutline>& outlines,
                       const std::vector<PatternBand>& bands, const SourceEllipse& source,
                       double inner, double outer)
    // The mean square distance from the middle of an ellipse is a quarter of a^2 + b^2.
    : source_radius2_(0.25 * (source.a.dot(source.a) + source.b.dot(source.b))),
      light_(0.0, 0.0, 0.0),
      by_wavelength_(0.0, 0.0, 0.0),
      by_wavelength2_(0.0, 0.0, 0.0) {
    FLARE_CHECK(!bands.empty() && inner > 0.0);
    double sum = 0.0;
    for (const PatternBand& band : bands) {
        light_ += band.weight;
        by_wavelength_ += band.weight * band.wavelength;
        by_wavelength2_ += band.weight * (band.wavelength * band.wavelength);
        // Single wavelengths may be negative in a colour.
        const double strength = band.weight.length();
        sum += strength;
        mean_wavelength_ += strength * band.wavelength;
    }
    mean_wavelength_ = sum > 0.0 ? mean_wavelength_ / sum : bands.front().wavelength;

    for (const ApertureOutline& outline : outlines) {
        for (const EdgeLoop& loop : outline) {
            AddLoop(loop, inner / mean_wavelength_);
            Loop points;
            for (const EdgePiece& piece : loop.pieces) {
                points.insert(points.end(), piece.begin(), piece.end() - 1);
            }
            area_ += SignedArea(points);
        }
    }
    FLARE_CHECK(area_ > 0.0);
    for (Spike& spike : spikes_) FillTable(spike, bands, source);
    BuildRings(inner, outer);
}

void FarPattern::AddLoop(const EdgeLoop& loop, double wavenumber) {
    struct End {
        Vec2d first, last;  // unit tangents
        bool straight;
        double width;
    };
    std::vector<End> ends;
    for (const EdgePiece& piece : loop.pieces) {
        double length = 0.0, turn = 0.0;
        for (std::size_t i = 0; i + 1 < piece.size(); ++i) {
            length += (piece[i + 1] - piece[i]).length();
            if (i > 0) turn += TurnFrom(piece[i] - piece[i - 1], piece[i + 1] - piece[i]);
        }
        const bool straight = !loop.smooth && std::abs(turn) * length * wavenumber < kStraight;
        if (straight) {
            AddSpike(piece, turn);
        } else {
            AddArcs(piece, loop.smooth);
        }
        // Where a corner's wave runs into a side's own: sinc^2 is flat for L k_t below 1 / (2 pi),
        // an arc's light for an angle below about 1 / sqrt(k R).
        const double width =
            straight ? 0.5 / (kPi * length) : 0.5 * std::sqrt(std::abs(turn) / length);
        ends.push_back({(piece[1] - piece[0]).normalized(),
                        (piece.back() - piece[piece.size() - 2]).normalized(), straight, width});
    }
    if (loop.smooth) return;
    for (std::size_t i = 0; i < ends.size(); ++i) {
        const End& next = ends[(i + 1) % ends.size()];
        corners_.push_back(
            {ends[i].last, next.first, ends[i].straight, next.straight, ends[i].width, next.width});
    }
}

void FarPattern::AddSpike(const EdgePiece& piece, double turn) {
    const Vec2d chord = piece.back() - piece.front();
    Spike spike;
    spike.tangent = chord.normalized();
    spike.length = chord.length();
    spike.spread = 0.5 * std::abs(turn);
    spikes_.push_back(std::move(spike));
}

// Every side of the polyline stands for the part of the arc whose normals lie halfway to those of
// its neighbours.
void FarPattern::AddArcs(const EdgePiece& piece, bool closed) {
    const std::size_t sides = piece.size() - 1;
    std::vector<Vec2d> side(sides);
    for (std::size_t i = 0; i < sides; ++i) side[i] = piece[i + 1] - piece[i];
    const auto turn = [&](std::size_t before, std::size_t after) {
        return TurnFrom(side[before], side[after]);
    };
    for (std::size_t i = 0; i < sides; ++i) {
        const bool first = i == 0 && !closed;
        const bool last = i + 1 == sides && !closed;
        double in = first ? 0.0 : turn((i + sides - 1) % sides, i);
        double out = last ? 0.0 : turn(i, (i + 1) % sides);
        if (first) in = out;
        if (last) out = in;
        const Vec2d normal = Normal(side[i]);
        arcs_.push_back({side[i].length(), std::atan2(normal.y, normal.x) + 0.25 * (out - in),
                         0.25 * std::abs(in + out)});
    }
}

void FarPattern::FillTable(Spike& spike, const std::vector<PatternBand>& bands,
                           const SourceEllipse& source) const {
    static const SincSquared kSinc;
    double longest = 0.0;
    for (const PatternBand& band : bands) longest = std::max(longest, band.wavelength);
    const double lobe = longest / spike.length;  // half-width of the broadest
    const double disc = source.HalfWidth(spike.tangent);
    spike.step = std::max({1.0 / 16.0, lobe / 64.0, disc / 64.0});
    spike.reach = std::max({24.0, 16.0 * lobe, 4.0 * disc + 8.0 * lobe});
    const int half = static_cast<int>(spike.reach / spike.step);
    spike.reach = half * spike.step;

    std::vector<Vec3d> cells(static_cast<std::size_t>(2 * half), Vec3d(0.0, 0.0, 0.0));
    for (const PatternBand& band : bands) {
        const double scale = spike.length / band.wavelength;
        double below = kSinc.Integral(-spike.reach * scale);
        for (int i = 0; i < 2 * half; ++i) {
            const double above = kSinc.Integral((i + 1 - half) * spike.step * scale);
            cells[static_cast<std::size_t>(i)] +=
                band.weight * ((above - below) / (scale * spike.step));
            below = above;
        }
    }
    cells = BoxMean(cells, 0.5 * std::abs(spike.tangent.x) / spike.step);
    cells = BoxMean(cells, 0.5 * std::abs(spike.tangent.y) / spike.step);
    cells = DiscMean(cells, disc / spike.step);
    spike.sums = Summed(cells);
}

void FarPattern::BuildRings(double inner, double outer) {
    if (arcs_.empty()) return;
    first_ring_ = inner;
    const double step = kPi / kAngles;
    for (double radius = inner;; radius *= kRingStep) {
        const double k = radius / mean_wavelength_;
        Ring& ring = rings_.emplace_back();
        ring.length_per_rad.assign(kAngles, 0.0);
        for (const Arc& arc : arcs_) {
            const double half = std::max(arc.half_angle, 1e-5);
            const double curvature_radius = arc.length / (2.0 * half);
            const double soft = std::max(kArcEnd / std::sqrt(k * curvature_radius), 0.5 * step);
            const double reach = half + 3.5 * soft;
            // The integral of erf / 2.
            const auto sum = [&](double angle) {
                const double x = angle / soft;
                return 0.5 * soft * (x * std::erf(x) + std::exp(-x * x) / std::sqrt(kPi));
            };
            // Share of the arc's normals, smoothed, in each angle.
            const double first = arc.normal_rad - reach;
            const int from = static_cast<int>(std::floor(first / step));
            const int to = static_cast<int>(std::floor((arc.normal_rad + reach) / step));
            const auto filled = [&](double angle) {
                const double a = angle - arc.normal_rad;
                return (sum(a + half) - sum(a - half)) / (2.0 * half);
            };
            double last = filled(from * step);
            for (int i = from; i <= to; ++i) {
                const double next = filled((i + 1) * step);
                const int at = ((i % kAngles) + kAngles) % kAngles;
                ring.length_per_rad[static_cast<std::size_t>(at)] +=
                    arc.length * (next - last) / step;
                last = next;
            }
        }
        if (radius >= outer) break;
    }
}

double FarPattern::LengthPerRad(Vec2d place, double radius) const {
    double turn = std::atan2(place.y, place.x) / kPi;
    turn -= std::floor(turn);
    const double at = turn * kAngles - 0.5;
    const double whole = std::floor(at);
    const double t = at - whole;
    const auto i = static_cast<std::size_t>((static_cast<int>(whole) + kAngles) % kAngles);
    const std::size_t next = (i + 1) % kAngles;
    const double level = std::clamp(std::log(radius / first_ring_) / std::log(kRingStep), 0.0,
                                    static_cast<double>(rings_.size() - 1));
    const auto r = std::min(static_cast<std::size_t>(level), rings_.size() - 1);
    const double s = level - static_cast<double>(r);
    const auto of = [&](const Ring& ring) {
        return ring.length_per_rad[i] * (1.0 - t) + ring.length_per_rad[next] * t;
    };
    return of(rings_[r]) * (1.0 - s) + of(rings_[std::min(r + 1, rings_.size() - 1)]) * s;
}

// sum of weight sinc^2(L along / wavelength), averaged over the pixel, the source and the spread:
// from the table and, beyond it, by the mean of sinc^2.
Vec3d FarPattern::SpikeProfile(const Spike& spike, double along, double radius) const {
    const double half = std::max(spike.spread * radius, spike.step);
    const double lo = along - half;
    const double hi = along + half;
    Vec3d light = (SumAt(spike.sums, (hi + spike.reach) / spike.step) -
                   SumAt(spike.sums, (lo + spike.reach) / spike.step)) *
                  spike.step;
    double tail = 0.0;
    if (hi > spike.reach) tail += 1.0 / std::max(spike.reach, lo) - 1.0 / hi;
    if (-lo > spike.reach) tail += 1.0 / std::max(spike.reach, -hi) + 1.0 / lo;
    light += by_wavelength2_ * (tail * 0.5 / (kPi * kPi * spike.length * spike.length));
    return light / (2.0 * half);
}

Vec3d FarPattern::At(Vec2d place) const {
    const double radius2 = place.dot(place);
    const double radius = std::sqrt(radius2);
    const Vec2d to = place / radius;
    const double k = radius / mean_wavelength_;
    // 1 / radius^n is bent: over the source its mean is larger by n^2 / 4 of the mean square (of a
    // spike only what lies along it counts).
    const double bend = source_radius2_ / radius2;
    Vec3d light(0.0, 0.0, 0.0);
    for (const Spike& spike : spikes_) {
        const double along = place.dot(spike.tangent);
        const double across = to.dot(Normal(spike.tangent));
        light +=
            SpikeProfile(spike, along, radius) * (spike.length * spike.length * across * across *
                                                  (1.0 + 1.5 * bend) / (4.0 * kPi * kPi * radius2));
    }
    double haze = 0.0;
    for (const Corner& corner : corners_) {
        const auto tau = [&](Vec2d tangent, bool straight, double width) {
            const double along = to.dot(tangent);
            const double w = straight ? width / k : width / std::sqrt(k);
            return to.dot(Normal(tangent)) * along / (along * along + w * w);
        };
        const double tau1 = tau(corner.tangent1, corner.straight1, corner.width1);
        const double tau2 = tau(corner.tangent2, corner.straight2, corner.width2);
        haze += (tau2 - tau1) * (tau2 - tau1) - (corner.straight1 ? tau1 * tau1 : 0.0) -
                (corner.straight2 ? tau2 * tau2 : 0.0);
    }
    light += by_wavelength2_ *
             (haze * (1.0 + 4.0 * bend) / (16.0 * std::pow(kPi, 4) * radius2 * radius2));
    if (!rings_.empty()) {
        light += by_wavelength_ * (LengthPerRad(place, radius) * (1.0 + 2.25 * bend) /
                                   (4.0 * kPi * kPi * radius2 * radius));
    }
    light /= area_;
    return light;
}

}  // namespace flare
