// SPDX-License-Identifier: Apache-2.0
//
// The text of lenses/glass/catalogue.tsv, put into the program at build time. Private to the
// catalogue (glass_catalogue.h).
#pragma once

#include <string_view>

namespace flare {

std::string_view GlassCatalogueText();

}  // namespace flare
