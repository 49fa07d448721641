// SPDX-License-Identifier: Apache-2.0
//
// A request's lights in the renderer's terms: a canonical light (field angle, azimuth where the
// lens is not rotational, and distance) and the pose that turns or mirrors it into place.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/image/ghost_walk.h"
#include "core/mesh/mesh_builder.h"
#include "core/render/flare_request.h"
#include "core/tracing/light_bundle.h"

namespace flare {

struct PlacedLight {
    Vec3d direction{0.0, 0.0, 1.0};  // camera axes, unit length, towards the light
    double field_rad = 0.0;          // from the axis, 0..pi
    CanonicalPose pose;
    double inverse_distance = 0.0;  // 1/mm from the entrance pupil's centre
    // Spectral: E0. Colour: the light's colour, in linear Rec.709.
    Vec3d irradiance{0.0, 0.0, 0.0};
    std::shared_ptr<const Spectrum> power;  // absent: that of a mix of primaries with this colour
    double angular_diameter_rad = 0.0;
    // What shines in place of a disc; null: a disc.
    std::shared_ptr<const SourcePicture> shape;
    // Radius of the finest parts of a shape; of a disc its own would be.
    std::optional<double> detail_rad;
    double share = 1.0;  // of the request's light that this one stands for
};

// The projection that `pixel` uses for this lens and request.
Projection ProjectionOf(const FlareRequest& request);

// Light number `index` of the request. Errors: the place cannot be seen, or lies inside the lens;
// `where` is "/lights/N/...".
Result<PlacedLight> PlaceLight(const FlareRequest& request, std::size_t index);

// The light's spectrum times `weight`, in colour.
Spectrum PowerOf(const PlacedLight& light, double weight = 1.0);
// The same light from another direction (camera axes, unit length).
PlacedLight FacedTo(const Lens& lens, PlacedLight light, const Vec3d& direction);

// Millimetres a pixel on the sensor, horizontally and vertically.
Vec2d PixelPitch(const FlareRequest& request);

// Width over height of a pixel when the picture is shown in the proportions of the scene.
double ShownPixelAspect(const FlareRequest& request);

// Sensor (canonical) to full-frame pixels for a light in this pose.
PictureMap MapOf(const FlareRequest& request, const CanonicalPose& pose);

// The rays of a placed light.
LightBundle BundleOf(const Lens& lens, const PlacedLight& light);

// The mesh of a ghost lit by a placed light; wavelengths and fineness are left to the caller.
MeshSpec MeshSpecOf(const BounceSequence& sequence, const PlacedLight& light);

}  // namespace flare
