// SPDX-License-Identifier: Apache-2.0
#include "core/spectrum/color_response.h"

#include "core/spectrum/sampled_curve.h"

namespace flare {
namespace {

const RgbMap& ToRec709(ColorSpace space) {
    static const std::array<RgbMap, 3> maps{RgbMap(Rec709Chromaticities(), Rec709Chromaticities()),
                                            RgbMap(Ap1Chromaticities(), Rec709Chromaticities()),
                                            RgbMap(Ap0Chromaticities(), Rec709Chromaticities())};
    return maps[static_cast<std::size_t>(space)];
}

const RgbMap& FromRec709(ColorSpace space) {
    static const std::array<RgbMap, 3> maps{RgbMap(Rec709Chromaticities(), Rec709Chromaticities()),
                                            RgbMap(Rec709Chromaticities(), Ap1Chromaticities()),
                                            RgbMap(Rec709Chromaticities(), Ap0Chromaticities())};
    return maps[static_cast<std::size_t>(space)];
}

ColorResponse InSpace(ColorSpace space) {
    ColorResponse response;
    for (std::size_t i = 0; i < response.size(); ++i) {
        response[i] = SpaceFromRec709(space, Rec709Response()[i]);
    }
    return response;
}

}  // namespace

const Chromaticities& ChromaticitiesOf(ColorSpace space) {
    switch (space) {
        case ColorSpace::kLinRec709:
            return Rec709Chromaticities();
        case ColorSpace::kAcesCg:
            return Ap1Chromaticities();
        case ColorSpace::kAces2065:
            return Ap0Chromaticities();
    }
    return Rec709Chromaticities();
}

// Rec.709 itself is left alone to the last bit.
Vec3d Rec709FromSpace(ColorSpace space, const Vec3d& rgb) {
    return space == ColorSpace::kLinRec709 ? rgb : ToRec709(space)(rgb);
}

Vec3d SpaceFromRec709(ColorSpace space, const Vec3d& rgb) {
    return space == ColorSpace::kLinRec709 ? rgb : FromRec709(space)(rgb);
}

const ColorResponse& ResponseOf(ColorSpace space) {
    static const ColorResponse acescg = InSpace(ColorSpace::kAcesCg);
    static const ColorResponse aces2065 = InSpace(ColorSpace::kAces2065);
    switch (space) {
        case ColorSpace::kLinRec709:
            return Rec709Response();
        case ColorSpace::kAcesCg:
            return acescg;
        case ColorSpace::kAces2065:
            return aces2065;
    }
    return Rec709Response();
}

std::optional<ColorResponse> ResponseOf(const CameraSensitivity& camera) {
    const Spectrum curves[] = {SpectrumOfCurve(camera.wavelengths_nm, camera.red),
                               SpectrumOfCurve(camera.wavelengths_nm, camera.green),
                               SpectrumOfCurve(camera.wavelengths_nm, camera.blue)};
    ColorResponse response;
    for (std::size_t i = 0; i < response.size(); ++i) {
        response[i] = {curves[0][i], curves[1][i], curves[2][i]};
    }
    const Vec3d white = ColorOf(response, WhiteSpectrum());
    if (!(white.x > 0.0 && white.y > 0.0 && white.z > 0.0)) return std::nullopt;
    for (Vec3d& value : response) value = {value.x / white.x, value.y / white.y, value.z / white.z};
    return response;
}

Vec3d ColorOf(const ColorResponse& response, const Spectrum& power) {
    Vec3d rgb(0.0);
    for (std::size_t i = 0; i < power.size(); ++i) rgb += response[i] * power[i];
    return rgb;
}

}  // namespace flare
