// SPDX-License-Identifier: Apache-2.0
//
// A coating as it is ordered from the coater: a name, and for any pair of media the stack to lay.
// Some stacks are the same everywhere; a V-coat depends on the glass. Wavelengths nm.
//
//   bare, none      nothing
//   mgf2-NNN        a quarter wave of the constant index 1.38 (mgf2-550 is 99.64 nm)
//   mgf2-disp-NNN   the same of magnesium fluoride with its dispersion
//   v-NNN           MgF2 over a high-index layer, thicknesses solved so that R is 0 at NNN
//   broadband-NNN   a quarter wave of MgF2, a half and a quarter wave of the two materials that
//                   reflect least on the glass
//   multi-NNN       seven layers, this project's design (lenses/coatings/multilayer.tsv), scaled
// with NNN, the design wavelength, from 300 to 1100.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/optics/coating.h"
#include "core/optics/glass.h"

namespace flare {

inline constexpr int kMaxCoatingLayers = 100;
inline constexpr double kMaxLayerIndex = 10.0;  // of n, which is above 0, and of k
inline constexpr double kMaxLayerThicknessNm = 1e5;

class CoatingDesign {
  public:
    CoatingDesign() = default;  // bare

    // The same layers on every pair of media, listed from the low-index side. Fails where a layer
    // is not one: too many, n <= 0, k < 0, a negative thickness, ...; and for the names "bare" and
    // "none", which always mean no layer.
    static Result<CoatingDesign> Stack(std::string name, std::vector<CoatingLayer> layers);

    const std::string& name() const { return name_; }
    // Of a stack that is the same everywhere; otherwise empty.
    const std::vector<CoatingLayer>& layers() const { return layers_; }
    Coating For(const Glass& rare, const Glass& dense) const;

    std::string notes, source;

    friend bool operator==(const CoatingDesign&, const CoatingDesign&) = default;

  private:
    friend Result<CoatingDesign> BuiltInCoating(std::string_view name);
    enum class Kind { kStack, kV, kBroadband, kMultilayer };

    std::string name_ = "bare";
    Kind kind_ = Kind::kStack;
    double design_nm_ = 0.0;            // unless kStack
    std::vector<CoatingLayer> layers_;  // of kStack
};

// What is wrong with a layer, as "k is -0.1 but must be 0 to 10"; "" if nothing.
std::string LayerFault(const CoatingLayer& layer);

// One of the names above. Fails with a message that lists them.
Result<CoatingDesign> BuiltInCoating(std::string_view name);

// A lens's own coatings, by name.
using CoatingDefinitions = std::map<std::string, CoatingDesign>;

// A lens's own coating of that name, else the built-in one.
Result<CoatingDesign> CoatingDesignByName(std::string_view name, const CoatingDefinitions& defined);

}  // namespace flare
