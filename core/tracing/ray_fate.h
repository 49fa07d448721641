// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace flare {

// How a ray's way through a bounce sequence ended.
enum class RayFate {
    kArrived,    // reached the sensor plane
    kVignetted,  // outside a surface's rim
    kStopped,    // outside the iris
    kMissed,     // did not meet a surface, or met surfaces out of order
    kTir,        // total internal reflection where the sequence asks for transmission
};

constexpr std::string_view Name(RayFate fate) {
    switch (fate) {
        case RayFate::kArrived:
            return "arrived";
        case RayFate::kVignetted:
            return "vignetted";
        case RayFate::kStopped:
            return "stopped";
        case RayFate::kMissed:
            return "missed";
        case RayFate::kTir:
            return "tir";
    }
    return "missed";
}

}  // namespace flare
