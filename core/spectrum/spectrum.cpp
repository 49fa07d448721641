// SPDX-License-Identifier: Apache-2.0
//
// The matrix from XYZ to Rec.709 is made from the chromaticities of the primaries and from the
// white that the table itself gives, not from the rounded (0.3127, 0.3290): then white is (1, 1, 1)
// by construction. White has luminance 1, so the responses need no further scale.
#include "core/spectrum/spectrum.h"

#include <cstddef>
#include <tuple>
#include <type_traits>

#include "core/spectrum/cie_table.h"
#include "core/spectrum/primaries_table.h"

namespace flare {
namespace {

static_assert(std::tuple_size_v<std::remove_cvref_t<decltype(CieTable())>> == kSpectrumSamples);
static_assert(std::tuple_size_v<std::remove_cvref_t<decltype(PrimariesTable())>> ==
              kSpectrumSamples);

// ITU-R BT.709: chromaticities of the primaries.
constexpr double kRed[] = {0.64, 0.33}, kGreen[] = {0.30, 0.60}, kBlue[] = {0.15, 0.06};

// XYZ with Y = 1.
Vec3d XyzFromChromaticity(const double (&xy)[2]) {
    return {xy[0] / xy[1], 1.0, (1.0 - xy[0] - xy[1]) / xy[1]};
}

Vec3d XyzOf(const CieRow& row) {
    return {row.x_bar, row.y_bar, row.z_bar};
}

Spectrum MakeWhite() {
    Spectrum white{};
    double luminance = 0.0;
    for (const CieRow& row : CieTable()) luminance += row.d65 * row.y_bar;
    for (int i = 0; i < kSpectrumSamples; ++i) {
        const auto n = static_cast<std::size_t>(i);
        white[n] = CieTable()[n].d65 / luminance;
    }
    return white;
}

std::array<Vec3d, kSpectrumSamples> MakeResponse() {
    const Spectrum& white = WhiteSpectrum();
    Vec3d white_xyz(0.0);
    for (std::size_t i = 0; i < white.size(); ++i) white_xyz += XyzOf(CieTable()[i]) * white[i];

    // Cramer's rule: the amounts of the three primaries in a colour are ratios of triple products;
    // divided by the amounts in white they are linear Rec.709.
    const Vec3d r = XyzFromChromaticity(kRed);
    const Vec3d g = XyzFromChromaticity(kGreen);
    const Vec3d b = XyzFromChromaticity(kBlue);
    const Vec3d to_r = g.cross(b) / white_xyz.dot(g.cross(b));
    const Vec3d to_g = b.cross(r) / white_xyz.dot(b.cross(r));
    const Vec3d to_b = r.cross(g) / white_xyz.dot(r.cross(g));

    std::array<Vec3d, kSpectrumSamples> response;
    for (std::size_t i = 0; i < response.size(); ++i) {
        const Vec3d xyz = XyzOf(CieTable()[i]);
        response[i] = {to_r.dot(xyz), to_g.dot(xyz), to_b.dot(xyz)};
    }
    return response;
}

}  // namespace

const std::array<Vec3d, kSpectrumSamples>& Rec709Response() {
    static const std::array<Vec3d, kSpectrumSamples> response = MakeResponse();
    return response;
}

const Spectrum& WhiteSpectrum() {
    static const Spectrum white = MakeWhite();
    return white;
}

Spectrum LightSpectrum(Vec3d rgb) {
    const Spectrum& white = WhiteSpectrum();
    Spectrum power;
    for (std::size_t i = 0; i < power.size(); ++i) {
        const PrimariesRow& mix = PrimariesTable()[i];
        power[i] = white[i] * (rgb.x * mix.red + rgb.y * mix.green + rgb.z * mix.blue);
    }
    return power;
}

Vec3d Rec709FromSpectrum(const Spectrum& power) {
    Vec3d rgb(0.0);
    for (std::size_t i = 0; i < power.size(); ++i) rgb += Rec709Response()[i] * power[i];
    return rgb;
}

}  // namespace flare
