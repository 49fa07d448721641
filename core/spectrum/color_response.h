// SPDX-License-Identifier: Apache-2.0
//
// What three channels make of a spectrum: for each sample of Spectrum the red, green and blue that
// unit power there gives, scaled so that WhiteSpectrum() gives (1, 1, 1). One for each RGB space,
// and one for any camera whose sensitivities are known. Values may be negative: a narrow light lies
// outside most spaces.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "core/base/chromaticities.h"
#include "core/spectrum/spectrum.h"

namespace flare {

using ColorResponse = std::array<Vec3d, kSpectrumSamples>;

enum class ColorSpace { kLinRec709, kAcesCg, kAces2065 };

const Chromaticities& ChromaticitiesOf(ColorSpace space);

// Linear values of one space as those of linear Rec.709 (D65 and ACES white by Bradford).
Vec3d Rec709FromSpace(ColorSpace space, const Vec3d& rgb);
Vec3d SpaceFromRec709(ColorSpace space, const Vec3d& rgb);

// The CIE 1931 observer in this space.
const ColorResponse& ResponseOf(ColorSpace space);

// Relative sensitivities of a camera at ascending wavelengths; straight lines between them, zero
// beyond.
struct CameraSensitivity {
    std::vector<double> wavelengths_nm;
    std::vector<double> red, green, blue;

    friend bool operator==(const CameraSensitivity&, const CameraSensitivity&) = default;
};

// White balanced: each channel is scaled by itself. Empty if a channel sees nothing of the white.
std::optional<ColorResponse> ResponseOf(const CameraSensitivity& camera);

// The three channels of a spectrum.
Vec3d ColorOf(const ColorResponse& response, const Spectrum& power);

}  // namespace flare
