// SPDX-License-Identifier: Apache-2.0
//
// The data files of lenses/coatings, built into the program.
#pragma once

#include <string_view>

namespace flare {

std::string_view CoatingMaterialsText();   // materials.tsv
std::string_view MultilayerDesignsText();  // multilayer.tsv

}  // namespace flare
