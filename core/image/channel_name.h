// SPDX-License-Identifier: Apache-2.0
//
// Which layer a channel belongs to: what stands before the last dot of its name; but the dot inside
// a spectral channel's own name ("S0.587,5618nm", "ghosts.S0.587,5618nm") parts nothing.
#pragma once

#include <string>

namespace flare {

// "" for a channel of the root.
inline std::string LayerOfChannel(const std::string& channel) {
    if (channel.starts_with("S0.")) return "";
    std::size_t dot = channel.find(".S0.");
    if (dot == std::string::npos) dot = channel.rfind('.');
    return dot == std::string::npos ? "" : channel.substr(0, dot);
}

}  // namespace flare
