// SPDX-License-Identifier: Apache-2.0
//
// Labels in a row that would like to stand at given places and must not overlap. A pure function.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace flare {

struct RowLabel {
    double wish = 0.0;   // where its middle would like to be
    double width = 0.0;  // with the space around it
};

// The middles of the labels, in the order given, such that neighbours do not overlap and the sum of
// the squared distances to the wishes is least; within lo .. hi where they fit there.
std::vector<double> SpreadLabels(const std::vector<RowLabel>& labels, double lo, double hi);

// About how wide a text is in a sans-serif face of this size.
double TextWidth(std::string_view text, double font_size);

}  // namespace flare
