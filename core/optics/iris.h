// SPDX-License-Identifier: Apache-2.0
//
// The opening that the iris blades leave in the stop plane. Coordinates are mm in the stop plane, x
// right and y up as seen from behind the camera.
//
// A round iris is a disc. With N blades it is the regular N-gon whose *area* equals that of the
// disc of the same f-number; rotation 0 puts a corner at +y, positive rotation is anticlockwise.
// Between straight blades (roundness 0) and the circle (roundness 1) each side is a circular arc
// whose sagitta is that share of the circle's. The stop's rim cuts the opening in any case.
//
// The opening is the intersection of the discs (or half-planes) of its edges, so that a polygon can
// be clipped by one edge after another and corners stay exact.
#pragma once

#include <vector>

#include "core/base/vec.h"

namespace flare {

struct IrisShape {
    int blades = 0;  // 0: round; else 3..32
    double roundness = 0.0;
    double rotation_deg = 0.0;

    friend bool operator==(const IrisShape&, const IrisShape&) = default;
};

class Iris {
  public:
    // `opening_semi_diameter_mm` is the radius of the disc whose area the opening has (before the
    // rim cuts it); `rim_semi_diameter_mm` that of the stop.
    Iris(const IrisShape& shape, double opening_semi_diameter_mm, double rim_semi_diameter_mm);

    struct Edge {
        Vec2d normal{0.0, 0.0};  // outward, for straight edges
        double offset = 0.0;     // distance of the straight edge from the centre
        Vec2d centre{0.0, 0.0};  // of the arc
        double radius = 0.0;     // 0: straight
    };

    // Signed distance to edge k in mm: negative inside. The opening is where all are negative.
    int edge_count() const { return static_cast<int>(edges_.size()); }
    const Edge& edge(int k) const { return edges_[static_cast<std::size_t>(k)]; }
    double EdgeDistance(int k, Vec2d p) const;

    // Largest edge distance: negative inside the opening.
    double Distance(Vec2d p) const;
    // No point of the opening lies farther from the centre than this.
    double outer_radius() const { return outer_radius_; }
    // Every point nearer to the centre than this lies in the opening.
    double inner_radius() const { return inner_radius_; }
    // 1e-6 relative; by quadrature where the rim cuts the opening, so not for a hot path.
    double area_mm2() const;

  private:
    std::vector<Edge> edges_;
    double outer_radius_ = 0.0, inner_radius_ = 0.0;
    double area_mm2_ = 0.0;  // before the rim cuts it
    bool rim_cuts_ = false;
};

}  // namespace flare
