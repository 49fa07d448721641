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
// Irregular blades stand nearer or farther (up to 15 %) and are turned (up to a third of the angle
// to the next corner), each by its own share, times `irregularity`; the opening keeps the disc's
// area.
//
// The opening is the intersection of the discs (or half-planes) of its edges, so that a polygon can
// be clipped by one edge after another and corners stay exact. What it lets through is multiplied
// by a picture, if there is one: a mask is scaled to have the area of the disc, or spans the stop's
// rim and multiplies the blades.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/vec.h"
#include "core/optics/stop_picture.h"

namespace flare {

enum class MaskScale {
    kArea,  // the f-number's, in place of blades
    kStop,  // the rim's, and blades and f-number cut as without a mask
};

struct IrisShape {
    int blades = 0;  // 0: round; else 3..32
    double roundness = 0.0;
    double rotation_deg = 0.0;  // of blades and mask
    double irregularity = 0.0;  // 0..1
    std::uint64_t seed = 0;     // of the irregular blades
    // Some light must pass. For kStop in units of the rim's radius, for kArea of any size.
    std::shared_ptr<const StopPicture> mask = nullptr;
    MaskScale mask_scale = MaskScale::kArea;

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

    // The same edges for light that fades out on either side of them: the outer radius is larger
    // and the inner one smaller, by `dark_mm` and `lit_mm`.
    Iris Widened(double dark_mm, double lit_mm) const;

    // Signed distance to edge k in mm: negative inside. The opening is where all are negative.
    int edge_count() const { return static_cast<int>(edges_.size()); }
    const Edge& edge(int k) const { return edges_[static_cast<std::size_t>(k)]; }
    double EdgeDistance(int k, Vec2d p) const;

    // Largest edge distance: negative inside the opening. The picture is not in it.
    double Distance(Vec2d p) const;
    // Multiplies what the edges let through; null: 1.
    const StopPicture* picture() const { return picture_.get(); }
    // What passes at a point, edges and picture together.
    double TransmissionAt(Vec2d p) const;
    // No light passes farther from the centre than this.
    double outer_radius() const { return outer_radius_; }
    // All light passes nearer to the centre than this, 0 if there is no such place.
    double inner_radius() const { return inner_radius_; }
    // The same of the edges alone, above 0 and not changed by widening.
    double edges_inner_radius() const { return edges_inner_radius_; }
    // How far outside its edges light may pass: 0 unless widened.
    double reach_mm() const { return reach_mm_; }
    // 1e-6 relative; by quadrature where the rim cuts the opening (1e-4 with a picture), so not for
    // a hot path.
    double area_mm2() const;

  private:
    void SetBlades(const IrisShape& shape, double opening_semi_diameter_mm);
    void SetIrregularBlades(const IrisShape& shape, double opening_semi_diameter_mm);
    void SetMask(const IrisShape& shape, double opening_semi_diameter_mm, double rim);
    double Reach(Vec2d direction) const;
    double RadialArea(int steps) const;

    std::vector<Edge> edges_;
    std::shared_ptr<const StopPicture> picture_;
    double outer_radius_ = 0.0, inner_radius_ = 0.0, edges_inner_radius_ = 0.0;
    double reach_mm_ = 0.0;
    double area_mm2_ = 0.0;  // before rim and picture
    bool rim_cuts_ = false;
};

}  // namespace flare
