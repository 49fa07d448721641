// SPDX-License-Identifier: Apache-2.0
//
// The ghosts of all lights by photons: the second truth beside the dense mesh (docs/physics/
// photon.md). kPhotonReplicates independent pictures, each stratified by itself, are averaged;
// their spread gives the standard error of every pixel. Samples go to lamps' sequences by the flux
// that a small pilot of its own found in them, a quarter of them evenly. Memory: 24 bytes a pixel
// and channel, and a bounded number of photons. The picture depends on request and seed alone.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/render/photon_map.h"
#include "core/render/render_scene.h"
#include "core/render/renderer.h"

namespace flare {

inline constexpr int kPhotonReplicates = 16;

class PhotonLayer {
  public:
    // The arguments must outlive the layer; facts and work are added to `report`.
    PhotonLayer(const RenderScene& scene, const RenderContext& context, Report& report);

    // Takes a light down; `reported`: its fluxes stand in the report.
    void Add(const PlacedLight& light, bool reported);
    // Traces everything. Error: cancelled, or more photons than "nearest" has room for.
    std::optional<Error> Run();

    // The layer's planes, light in a pixel times `scale`.
    std::vector<std::vector<float>> Resolve(double scale) const;
    // The standard error of each, as "photon_error.R", ....
    void AppendErrorTo(FlareImage& image, double scale) const;

  private:
    struct Lamp {
        PhotonSource source;
        PhotonColors colors;      // in colour
        double irradiance = 0.0;  // spectral
        bool reported = false;
        // Of each sequence; strata in one replicate.
        std::vector<PhotonRegion> regions;
        std::vector<PhotonStrata> strata;
    };
    // Some samples of one sequence of one lamp.
    struct Item {
        std::size_t lamp = 0, sequence = 0;
        std::int64_t first = 0;
        int count = 0;
    };

    using ColorsOfLamp = std::function<const PhotonColors&(const Lamp&)>;
    using Take = std::function<void(const Item&, const LandedPhotons&)>;

    void FindRegions();
    void Pilot();
    void AddReplicate(int replicate, std::size_t channel);
    std::vector<Item> Items() const;
    // Traces all samples of a replicate, a few items at a time, and hands them over in order.
    void Trace(int replicate, std::size_t channel, const ColorsOfLamp& colors, const Take& take);
    void SetFacts();
    double Mean(std::size_t at) const;
    double StandardError(std::size_t at) const;

    const RenderScene& scene_;
    const RenderContext& context_;
    Report& report_;
    PhotonSpec spec_;
    SensorMap sensor_;
    std::vector<BounceSequence> sequences_;
    std::vector<Lamp> lamps_;
    PhotonMap map_;
    bool too_many_ = false;  // photons for "nearest"
    std::uint64_t landed_ = 0;
    // Channel after channel: sums over the replicates of the light a pixel and of its square.
    std::vector<double> sum_, squares_;
};

}  // namespace flare
