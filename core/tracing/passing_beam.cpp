// SPDX-License-Identifier: Apache-2.0
//
// From a ray that passes, a box grows about it until none passes on its border; the box is shrunk
// to what passed inside it and cut into chords.
#include "core/tracing/passing_beam.h"

#include <algorithm>
#include <array>

namespace flare {
namespace {

constexpr int kScanSteps = 1024;  // along v = 0, to find the beam
constexpr int kLookSteps = 40;    // across the box, to find its size
constexpr int kChords = 72;
constexpr int kChordSteps = 36;    // along a chord, to find where it begins and ends
constexpr int kEdgeHalvings = 12;  // of one such step

// Gauss-Legendre on 0..1 with four points.
constexpr std::array<double, 4> kGaussAt{0.06943184420297371, 0.33000947820757187,
                                         0.6699905217924281, 0.9305681557970263};
constexpr std::array<double, 4> kGaussWeight{0.17392742256872693, 0.32607257743127307,
                                             0.32607257743127307, 0.17392742256872693};

using Box = PassingBeam::Box;

class Probe {
  public:
    explicit Probe(const RayPlane& plane) : plane_(plane) {}

    bool Passes(double u, double v) const { return plane_.passes(u, v); }

    // Between a u that passes and one that does not.
    double Edge(double inside, double outside, double v) const {
        for (int i = 0; i < kEdgeHalvings; ++i) {
            const double mid = 0.5 * (inside + outside);
            (Passes(mid, v) ? inside : outside) = mid;
        }
        return 0.5 * (inside + outside);
    }

    double left() const { return plane_.centre_u - plane_.half_width; }
    double right() const { return plane_.centre_u + plane_.half_width; }
    double top() const { return plane_.half_width; }

  private:
    const RayPlane& plane_;
};

// A box that holds the beam around (u, 0), and at most a few of its own steps more.
Box BoxAround(const Probe& probe, double u) {
    const double reach = 0.25 * probe.top();
    Box box{u - reach, u + reach, reach};
    constexpr int kMostLooks = 24;
    for (int look = 0; look < kMostLooks; ++look) {
        const double du = (box.u1 - box.u0) / kLookSteps;
        const double dv = box.v1 / (kLookSteps / 2);
        Box found{u, u, 0.0};
        bool at_left = false, at_right = false, at_top = false;
        for (int j = 0; j <= kLookSteps / 2; ++j) {
            for (int i = 0; i <= kLookSteps; ++i) {
                const double at = box.u0 + i * du;
                if (!probe.Passes(at, j * dv)) continue;
                found = {std::min(found.u0, at), std::max(found.u1, at),
                         std::max(found.v1, j * dv)};
                at_left = at_left || i == 0;
                at_right = at_right || i == kLookSteps;
                at_top = at_top || j == kLookSteps / 2;
            }
        }
        const bool grown = (at_left && box.u0 > probe.left()) ||
                           (at_right && box.u1 < probe.right()) || (at_top && box.v1 < probe.top());
        const bool coarse = found.u1 - found.u0 < 10.0 * du || found.v1 < 5.0 * dv;
        if (!grown && !coarse) return {found.u0 - du, found.u1 + du, found.v1 + dv};
        if (grown) {
            const double width = box.u1 - box.u0;
            if (at_left) box.u0 = std::max(probe.left(), box.u0 - width);
            if (at_right) box.u1 = std::min(probe.right(), box.u1 + width);
            if (at_top) box.v1 = std::min(probe.top(), 2.0 * box.v1);
        } else {
            box = {found.u0 - du, found.u1 + du, found.v1 + dv};
        }
    }
    return box;
}

// The runs of rays that pass on one line.
void AddChords(const Probe& probe, const Box& box, double v,
               std::vector<PassingBeam::Chord>& chords) {
    const double du = (box.u1 - box.u0) / kChordSteps;
    double last_u = box.u0, begin = box.u0;
    bool inside = probe.Passes(last_u, v);
    for (int i = 1; i <= kChordSteps; ++i) {
        const double u = box.u0 + i * du;
        const bool passes = probe.Passes(u, v);
        if (passes && !inside) begin = probe.Edge(u, last_u, v);
        if (!passes && inside) chords.push_back({v, begin, probe.Edge(last_u, u, v)});
        inside = passes;
        last_u = u;
    }
    if (inside) chords.push_back({v, begin, last_u});
}

}  // namespace

double PassingBeam::area_mm2() const {
    double length = 0.0;
    for (const Chord& chord : chords) length += chord.u1 - chord.u0;
    return 2.0 * pitch_mm * length;
}

std::vector<PassingBeam::Node> PassingBeam::Nodes() const {
    std::vector<Node> nodes;
    nodes.reserve(chords.size() * kGaussAt.size());
    for (const Chord& chord : chords) {
        const double width = chord.u1 - chord.u0;
        for (std::size_t k = 0; k < kGaussAt.size(); ++k) {
            nodes.push_back({chord.u0 + width * kGaussAt[k], chord.v,
                             2.0 * pitch_mm * width * kGaussWeight[k]});
        }
    }
    return nodes;
}

std::optional<double> PassingPlace(const RayPlane& plane) {
    if (plane.hint_u && plane.passes(*plane.hint_u, 0.0)) return plane.hint_u;
    for (int i = 0; i < kScanSteps; ++i) {
        const double u = plane.centre_u + plane.half_width * (2.0 * (i + 0.5) / kScanSteps - 1.0);
        if (plane.passes(u, 0.0)) return u;
    }
    return std::nullopt;
}

PassingBeam FindPassingBeam(const RayPlane& plane) {
    PassingBeam beam;
    const std::optional<double> u = PassingPlace(plane);
    if (!u) return beam;
    const Probe probe(plane);
    beam.box = BoxAround(probe, *u);
    beam.pitch_mm = beam.box.v1 / kChords;
    for (int j = 0; j < kChords; ++j) {
        AddChords(probe, beam.box, (j + 0.5) * beam.pitch_mm, beam.chords);
    }
    return beam;
}

}  // namespace flare
