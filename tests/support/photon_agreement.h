// SPDX-License-Identifier: Apache-2.0
//
// Do mesh and photons agree within the Monte Carlo error? A picture of few, large pixels (blocks of
// the sensor) is made by both; each block's difference over its standard error is one t of
// Student's distribution with one degree of freedom less than there are replicates.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/render/photon_layer.h"
#include "tests/support/rendering.h"

namespace flare::testing {

struct PhotonAgreement {
    int blocks = 0;
    double mean_t2 = 0.0;  // kExpectedT2 if they agree
    double largest_t = 0.0;
    double sigma = 0.0;             // (mean_t2 - expected) over its own spread for this many blocks
    double photon_over_mesh = 0.0;  // all light, less 1
    double error = 0.0;             // standard errors of the blocks, over the light, in the mean
};

inline constexpr double kFreedom = kPhotonReplicates - 1;
inline constexpr double kExpectedT2 = kFreedom / (kFreedom - 2.0);

// Blocks with less light than this share of the mean hold too few photons for a normal spread.
inline constexpr double kCountedBlock = 0.2;

// `request` by mesh at a preset, and by photons with this many samples a ghost.
inline PhotonAgreement Agreement(FlareRequest request, std::int64_t samples, std::uint64_t seed,
                                 Studio& studio, QualityPreset preset = QualityPreset::kReference) {
    request.quality = preset;
    const FlareImage mesh = studio.Shoot(request).image;
    request.quality = QualityPreset::kReference;
    PhotonSpec photon;
    photon.samples = samples;
    photon.seed = seed;
    request.photon = photon;
    const FlareImage counted = studio.Shoot(request).image;

    PhotonAgreement agreement;
    double mesh_light = 0.0, photon_light = 0.0, error = 0.0, counted_light = 0.0;
    for (const ImagePlane& plane : mesh.planes) {
        if (plane.name.starts_with("ghosts.")) continue;
        const ImagePlane& other = PlaneNamed(counted, plane.name);
        const ImagePlane& errors = PlaneNamed(counted, "photon_error." + plane.name);
        const double mean = Sum(plane) / static_cast<double>(plane.values.size());
        mesh_light += Sum(plane);
        photon_light += Sum(other);
        for (std::size_t i = 0; i < plane.values.size(); ++i) {
            const double truth = plane.values[i], se = errors.values[i];
            if (truth < kCountedBlock * mean || se == 0.0) continue;
            const double t = (static_cast<double>(other.values[i]) - truth) / se;
            ++agreement.blocks;
            agreement.mean_t2 += t * t;
            agreement.largest_t = std::max(agreement.largest_t, std::abs(t));
            error += se;
            counted_light += truth;
        }
    }
    agreement.mean_t2 /= std::max(1, agreement.blocks);
    const double variance = 2.0 * kFreedom * kFreedom * (kFreedom - 1.0) /
                            ((kFreedom - 2.0) * (kFreedom - 2.0) * (kFreedom - 4.0));
    agreement.sigma =
        (agreement.mean_t2 - kExpectedT2) / std::sqrt(variance / std::max(1, agreement.blocks));
    agreement.photon_over_mesh = photon_light / mesh_light - 1.0;
    agreement.error = error / counted_light;
    return agreement;
}

}  // namespace flare::testing
