// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/render/compare.h"

namespace flare {

// `flare compare --json`: the metrics over all channels, then those of each layer ("" is the root).
std::string ComparisonJson(const Comparison& comparison);

}  // namespace flare
