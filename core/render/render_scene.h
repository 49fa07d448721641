// SPDX-License-Identifier: Apache-2.0
//
// What every layer of one render starts from: the request with its defaults worked out.
#pragma once

#include "core/base/cancel.h"
#include "core/image/flare_image.h"
#include "core/optics/iris.h"
#include "core/optics/paraxial.h"
#include "core/render/flare_request.h"
#include "core/render/quality.h"

namespace flare {

struct RenderScene {
    explicit RenderScene(const FlareRequest& asked);

    bool spectral() const { return request.color == ColorMode::kSpectral; }
    // Planes of a layer: the request's wavelengths, or red, green and blue.
    std::size_t channel_count() const { return spectral() ? request.wavelengths_nm.size() : 3; }
    // "R", "G", "B", or by the spectral OpenEXR layout.
    std::string ChannelName(std::size_t channel) const;

    const FlareRequest& request;  // outlives the scene
    const Lens& lens;
    QualitySettings settings;
    StopSetting stop;
    Iris iris;
    PixelWindow window;             // that is drawn: the frame with its overscan, or the crop
    double working_f_number = 0.0;  // at this opening
    double t_axis = 0.0;            // of the direct path, at the d line
    double scene_linear_factor = 1.0;
    // From sensor irradiance to the request's units.
    double units_factor = 1.0;
};

}  // namespace flare
