// SPDX-License-Identifier: Apache-2.0
//
// What a test needs to render: a thread pool, meshes remembered for the test's own time (several
// pictures of one light trace it once), and shorthands for requests and pictures.
#pragma once

#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "core/base/check.h"
#include "core/base/units.h"
#include "core/render/compare.h"
#include "core/render/renderer.h"

namespace flare::testing {

class RememberingMeshes final : public MeshProvider {
  public:
    Result<Found> Get(const Fingerprint& key, const Build& build, const CancelToken&) override {
        {
            const std::lock_guard lock(mutex_);
            const auto known = meshes_.find(key);
            if (known != meshes_.end()) return Found{known->second, true};
        }
        auto mesh = std::make_shared<const GhostMesh>(build());
        const std::lock_guard lock(mutex_);
        meshes_[key] = mesh;
        return Found{mesh, false};
    }

  private:
    std::mutex mutex_;
    std::map<Fingerprint, std::shared_ptr<const GhostMesh>> meshes_;
};

class Studio {
  public:
    explicit Studio(int threads = 2) : threads_(threads) {}

    RenderContext Context() {
        return {threads_, meshes_, CancelToken(), [] {
                    const auto now = std::chrono::steady_clock::now().time_since_epoch();
                    return std::chrono::duration<double, std::milli>(now).count();
                }};
    }
    Rendering Shoot(const FlareRequest& request) {
        Result<Rendering> rendering = Render(request, Context());
        if (!rendering) {
            CheckFailed((rendering.error().where + ": " + rendering.error().message).c_str(),
                        __FILE__, __LINE__);
        }
        return std::move(*rendering);
    }

  private:
    ThreadPool threads_;
    RememberingMeshes meshes_;
};

// A light at infinity whose light travels along (sin field, 0, cos field) in lens space, turned by
// `azimuth_deg` about the axis.
inline LightSpec LightAt(double field_deg, double azimuth_deg = 0.0) {
    const double field = RadiansFromDegrees(field_deg);
    const double azimuth = RadiansFromDegrees(azimuth_deg);
    LightSpec light;
    light.direction = Vec3d(-std::sin(field) * std::cos(azimuth),
                            -std::sin(field) * std::sin(azimuth), std::cos(field));
    return light;
}

// One wavelength, absolute irradiance, round iris, 36 mm wide frame, every ghost drawn.
inline FlareRequest SpectralRequest(std::shared_ptr<const Lens> lens, double f_number, int width,
                                    int height) {
    FlareRequest request;
    request.lens = std::move(lens);
    request.f_number = f_number;
    request.image.width = width;
    request.image.height = height;
    request.units = Units::kSensorIrradiance;
    request.color = ColorMode::kSpectral;
    request.model.culling = CullingRule::kNone;
    request.wavelengths_nm = {kLineD};
    return request;
}

inline const ImagePlane& PlaneNamed(const FlareImage& image, const std::string& name) {
    for (const ImagePlane& plane : image.planes) {
        if (plane.name == name) return plane;
    }
    CheckFailed(name.c_str(), __FILE__, __LINE__);
}

inline double Sum(const ImagePlane& plane) {
    double sum = 0.0;
    for (const float value : plane.values) sum += value;
    return sum;
}

// Relative L1 distance over all channels.
inline double RelL1(const FlareImage& image, const FlareImage& reference) {
    const Result<Comparison> comparison = Compare(image, reference);
    FLARE_CHECK(comparison.ok());
    return comparison->all.rel_l1;
}

}  // namespace flare::testing
