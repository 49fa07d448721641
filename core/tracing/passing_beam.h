// SPDX-License-Identifier: Apache-2.0
//
// The part of a plane of rays that passes a lens, cut into chords: lines of constant v whose ends
// on rims and iris are found by bisection. What varies smoothly over it (transmittance, say) is
// then integrated with few rays. The caller says which rays pass; its plane is mm and symmetric in
// v.
//
// The area is good to 5e-4 of itself (tests: FieldOfABall.*, PassingBeam.*). About 6 000 rays.
#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace flare {

struct RayPlane {
    std::function<bool(double u, double v)> passes;  // the same for v and -v
    // Every ray that passes lies in the square of this half-width about (centre_u, 0).
    double centre_u = 0.0, half_width = 0.0;
    // Where a ray may pass, v = 0: a beam narrower than 1/1024 of the square is found only there.
    std::optional<double> hint_u;
};

struct PassingBeam {
    struct Chord {
        double v = 0.0, u0 = 0.0, u1 = 0.0;
    };
    struct Node {
        double u = 0.0, v = 0.0, area_mm2 = 0.0;
    };
    // Holds the beam, v from -v1 to v1; a little wider than it.
    struct Box {
        double u0 = 0.0, u1 = 0.0, v1 = 0.0;
    };

    Box box;
    std::vector<Chord> chords;  // v > 0; the other half of the beam mirrors them
    double pitch_mm = 0.0;      // of neighbouring v

    bool empty() const { return chords.empty(); }
    double area_mm2() const;
    // Gauss-Legendre points on every chord, each with its share of the whole beam's area.
    std::vector<Node> Nodes() const;
};

// A u on the line v = 0 at which a ray passes, empty if there is none. A beam is connected and its
// own mirror image, so one that does not cross that line does not exist.
std::optional<double> PassingPlace(const RayPlane& plane);

PassingBeam FindPassingBeam(const RayPlane& plane);

}  // namespace flare
