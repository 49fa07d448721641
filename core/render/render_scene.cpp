// SPDX-License-Identifier: Apache-2.0
#include "core/render/render_scene.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "core/base/units.h"

namespace flare {
namespace {

PixelWindow DataWindow(const ImageSpec& image) {
    if (image.crop) {
        const auto& [x, y, w, h] = *image.crop;
        return {x, y, w, h};
    }
    const auto& [left, top, right, bottom] = image.overscan;
    return {-left, -top, image.width + left + right, image.height + top + bottom};
}

// "587.5618" -> "S0.587,5618nm": the spectral OpenEXR layout (Fichet, Pacanowski, Wilkie 2021).
std::string SpectralName(double wavelength_nm) {
    std::array<char, 40> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), wavelength_nm).ptr;
    std::string digits(text.data(), end);
    std::replace(digits.begin(), digits.end(), '.', ',');
    return "S0." + digits + "nm";
}

}  // namespace

RenderScene::RenderScene(const FlareRequest& asked)
    : request(asked),
      lens(*asked.lens),
      settings(SettingsOf(asked)),
      stop(StopForFNumber(lens, asked.f_number.value_or(lens.f_number()))),
      iris(asked.iris, stop.semi_diameter_mm,
           lens.surfaces()[static_cast<std::size_t>(lens.stop_index())].semi_diameter_mm),
      window(DataWindow(asked.image)),
      working_f_number(WorkingBeam(lens, stop.semi_diameter_mm).working_f_number),
      t_axis(AxialTransmittance(lens, kLineD)),
      scene_linear_factor(4.0 * working_f_number * working_f_number / (kPi * t_axis)),
      units_factor(asked.units == Units::kSceneLinear ? scene_linear_factor : 1.0) {}

std::string RenderScene::ChannelName(std::size_t channel) const {
    static const char* const kRgb[] = {"R", "G", "B"};
    return spectral() ? SpectralName(request.wavelengths_nm[channel]) : kRgb[channel];
}

}  // namespace flare
