// SPDX-License-Identifier: Apache-2.0
//
// Names of OpenEXR's standard attributes where there is one (lensModel, aperture in f-stops,
// nominalFocalLength in mm, focus in metres); the rest begins with "flare". A picture focused at
// infinity has no focus attribute: readers differ in what they make of an infinite one.
#include <array>
#include <cstdio>
#include <map>

#include "core/render/ghost_split.h"
#include "server/translate/report_json.h"

namespace flare {
namespace {

std::string Joined(const std::vector<std::string>& parts, const char* separator) {
    std::string all;
    for (const std::string& part : parts) all += (all.empty() ? "" : separator) + part;
    return all;
}

// "geometric: 45", the number of ghosts for each model that ran.
std::string ModelsText(const std::vector<GhostFacts>& ghosts) {
    std::map<std::string, int> counts;
    for (const GhostFacts& ghost : ghosts) ++counts[ghost.model];
    std::vector<std::string> parts;
    for (const auto& [model, count] : counts) {
        parts.push_back(model + ": " + std::to_string(count));
    }
    return Joined(parts, "; ");
}

// "9_1: gain 2, tint 1 0.5 0.2; 6_2: mute".
std::string ArtistText(const std::vector<ArtistGhost>& ghosts) {
    std::vector<std::string> parts;
    for (const ArtistGhost& ghost : ghosts) {
        std::array<char, 160> text{};
        const Vec3d& tint = ghost.tint;
        if (ghost.mute) {
            std::snprintf(text.data(), text.size(), "mute");
        } else {
            std::snprintf(text.data(), text.size(), "gain %.9g, tint %.9g %.9g %.9g", ghost.gain,
                          tint.x, tint.y, tint.z);
        }
        parts.push_back(SequenceLabel(ghost.sequence) + ": " + text.data());
    }
    return Joined(parts, "; ");
}

}  // namespace

void AddFactAttributes(const FlareRequest& request, const Facts& facts,
                       const std::string& request_hash, FlareImage& image) {
    const Lens& lens = *request.lens;
    const bool spectral = request.color == ColorMode::kSpectral;
    auto& texts = image.text_attributes;
    texts.emplace_back("lens", lens.name());
    texts.emplace_back("lensModel", lens.name());
    if (!lens.prescription().maker.empty()) {
        texts.emplace_back("lensMake", lens.prescription().maker);
    }
    texts.emplace_back("flareRequestHash", request_hash);
    texts.emplace_back("flareUnits",
                       request.units == Units::kSceneLinear ? "scene_linear" : "sensor_irradiance");
    texts.emplace_back("flareColorSpace", ColorSpaceName(request));
    if (!facts.ghosts.empty()) texts.emplace_back("flareModels", ModelsText(facts.ghosts));
    if (!request.artist.empty()) texts.emplace_back("flareArtist", ArtistText(request.artist));
    if (!facts.clamped.empty()) texts.emplace_back("flareClamped", Joined(facts.clamped, "; "));
    if (spectral) texts.emplace_back("spectralLayoutVersion", "1.0");

    auto& numbers = image.number_attributes;
    numbers.emplace_back("aperture", facts.f_number);
    const double efl_mm = lens.first_order(lens.prescription().design_section).efl_mm;
    numbers.emplace_back(
        "nominalFocalLength",
        facts.zoom_mm.value_or(lens.prescription().design_focal_mm.value_or(efl_mm)));
    numbers.emplace_back("effectiveFocalLength", efl_mm);
    if (facts.focus_m) numbers.emplace_back("focus", *facts.focus_m);
    if (facts.zoom_mm) numbers.emplace_back("flareZoom", *facts.zoom_mm);
    if (!lens.rotational()) {
        numbers.emplace_back("flareSqueeze", facts.squeeze);
        numbers.emplace_back("flareDesqueezed", request.image.desqueeze ? 1.0 : 0.0);
    }
    numbers.emplace_back("flareWorkingFNumber", facts.working_f_number);
    numbers.emplace_back("flareAxialTransmittance", facts.t_axis);
    numbers.emplace_back("flareSceneLinearFactor", facts.scene_linear_factor);
    numbers.emplace_back("flareCulledFlux", facts.culled_flux_mm2);
    if (facts.starburst && !facts.starburst->core) {
        numbers.emplace_back("flareStarburstCoreShare", facts.starburst->core_share);
    }
    numbers.emplace_back("flareEstimatedError", facts.estimated_error.rel_l1);
}

}  // namespace flare
