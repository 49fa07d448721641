// SPDX-License-Identifier: Apache-2.0
//
// Where the light of one lamp enters the lens, for random samples: a place on the front surface
// within its rim and a point of the lamp's disc or shape give a ray and the light it stands for. In
// lens space, through the surface itself; nothing of it is shared with the meshes' rays, which come
// from a plane across the beam.
#pragma once

#include <optional>

#include "core/render/lights.h"
#include "core/tracing/trace_reference.h"

namespace flare {

struct PhotonRay {
    Ray ray;  // starts kPhotonRun_mm before the front surface
    // Light through the surroundings of the ray per area of the rim's disc, for E0 = 1.
    double density = 0.0;
};

inline constexpr double kPhotonRun_mm = 1.0;

class PhotonSource {
  public:
    // Keeps a reference to the lens.
    PhotonSource(const Lens& lens, const PlacedLight& light);

    // `front` and `lamp` in [0, 1)^2, each mapped to its disc with equal areas, or
    // `lamp` to the image of its shape. Empty: the surface
    // is in its own shadow there.
    std::optional<PhotonRay> At(Vec2d front, Vec2d lamp) const;
    // Is the lamp a disc or a shape, no point?
    bool extended() const { return tan_radius_ > 0.0; }
    // Of the rim's disc.
    double area_mm2() const;

  private:
    // How much the lamp's point `lamp` leans its light, and how bright it is there, mean 1.
    Vec3d LeanOf(Vec2d lamp, double& brightness) const;

    const LensSurface& front_;
    Vec3d travel_, across_, up_;  // of the light's middle; unit vectors across it
    Vec3d pupil_;
    double distance_mm_ = 0.0;  // 0: infinity
    double tan_radius_ = 0.0;   // of the lamp's disc, or half its shape's width
    std::shared_ptr<const SourcePicture> shape_;
    Vec3d shape_right_{0.0, 0.0, 0.0}, shape_up_{0.0, 0.0, 0.0};  // as travel
};

}  // namespace flare
