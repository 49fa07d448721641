// SPDX-License-Identifier: Apache-2.0
//
// The starburst: the Fraunhofer diffraction pattern of each light's direct image, in absolute
// light, over the whole picture. The aperture is the beam that iris and rims let through at the
// light's field angle (beam_outline.h); its transform is scaled by the wavelength and by the 2 x 2
// scale of the chief ray at that place; every pixel holds the light that falls into it. A light of
// angular diameter is the pattern's sum over its disc. docs/physics/starburst.md.
//
// A pixel's light depends on the request alone, not on the window, the threads or other lights.
#pragma once

#include <optional>
#include <vector>

#include "core/base/cancel.h"
#include "core/base/parallel.h"
#include "core/image/flare_image.h"
#include "core/render/beam_outline.h"
#include "core/render/flare_request.h"
#include "core/render/layer_planes.h"
#include "core/render/lights.h"
#include "core/render/report.h"
#include "core/render/spot_pattern.h"

namespace flare {

class StarburstLayer {
  public:
    // `opening_semi_diameter_mm` is that of the iris. Of each light's pattern the tails are left
    // out that cannot put as much as `least_light` into a pixel of any channel. The request
    // outlives the layer.
    StarburstLayer(const FlareRequest& request, double opening_semi_diameter_mm,
                   const PixelWindow& window, double least_light = 0.0);

    // Adds a light's pattern. Stops early, leaving the layer unfinished, when cancelled.
    void Add(const PlacedLight& light, ThreadPool& threads, const CancelToken& cancel);

    // Light in a pixel times `scale`.
    LayerPlanes Resolve(double scale) const;
    // Back to a picture without light.
    void Clear();

    const StarburstFacts& facts() const { return facts_; }
    // The tails left out; `peak` is light in a pixel.
    const UnseenFacts& unseen() const { return unseen_; }

  private:
    // Of a light that is a point or a disc, or stands in the middle of a shape's cell.
    void AddSpot(const PlacedLight& light, const SourceCell& shape, ThreadPool& threads,
                 const CancelToken& cancel);
    // Where a light's image stands and how directions spread there.
    struct Spot {
        std::vector<double> nodes_nm;  // wavelengths at which places are known
        std::vector<Vec2d> places;     // full-frame pixels
        Vec2d middle{0.0, 0.0};        // at the d line
        // Pixels a radian, for light turned along the bundle's u and v.
        Vec2d along_u{0.0, 0.0}, along_v{0.0, 0.0};
        double area_mm2 = 0.0;  // of the beam, a mean over the iris's turns
        std::vector<ApertureOutline> outlines;

        Vec2d PlaceAt(double wavelength_nm) const;
    };

    bool PlaceSpot(const PlacedLight& light, const LightBundle& bundle, Spot& spot) const;
    std::optional<BeamOutline> AddOutlines(const PlacedLight& light, const LightBundle& bundle,
                                           Spot& spot, ThreadPool& threads) const;
    std::vector<SpotBand> BandsOf(const PlacedLight& light, const LightBundle& bundle,
                                  const BeamOutline& beam, const Spot& spot,
                                  ThreadPool& threads) const;
    PixelWindow SeenOf(const Spot& spot, const std::vector<SpotBand>& bands,
                       const SpotSource& source, double flux_mm2);
    void Draw(const SpotPattern& pattern, const PixelWindow& window, std::size_t first_plane,
              ThreadPool& threads, const CancelToken& cancel);

    const FlareRequest& request_;
    double opening_semi_diameter_mm_;
    PixelWindow window_;
    double least_light_;
    bool spectral_;
    std::vector<std::vector<double>> planes_;  // light in each pixel, E0 mm^2
    StarburstFacts facts_;
    UnseenFacts unseen_;
};

}  // namespace flare
