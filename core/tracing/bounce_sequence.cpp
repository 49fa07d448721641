// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/bounce_sequence.h"

namespace flare {

std::vector<int> ReflectingSurfaces(const Lens& lens, bool with_sensor) {
    std::vector<int> reflecting;
    for (int i = 0; i < static_cast<int>(lens.surfaces().size()); ++i) {
        const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(i)];
        if (surface.is_stop() || lens.MediumBefore(i) == lens.MediumBehind(i)) continue;
        reflecting.push_back(i);
    }
    if (with_sensor && lens.sensor() && lens.sensor()->reflectance > 0.0) {
        reflecting.push_back(lens.sensor_index());
    }
    return reflecting;
}

std::vector<BounceSequence> TwoReflectionSequences(const Lens& lens, bool with_sensor) {
    const std::vector<int> reflecting = ReflectingSurfaces(lens, with_sensor);
    std::vector<BounceSequence> sequences;
    for (std::size_t first = 0; first < reflecting.size(); ++first) {
        for (std::size_t second = 0; second < first; ++second) {
            sequences.push_back({reflecting[first], reflecting[second]});
        }
    }
    return sequences;
}

std::vector<BounceSequence> FourReflectionSequences(const Lens& lens, bool with_sensor) {
    const std::vector<int> at = ReflectingSurfaces(lens, with_sensor);
    std::vector<BounceSequence> sequences;
    for (std::size_t r1 = 0; r1 < at.size(); ++r1) {
        for (std::size_t r2 = 0; r2 < r1; ++r2) {
            for (std::size_t r3 = r2 + 1; r3 < at.size(); ++r3) {
                for (std::size_t r4 = 0; r4 < r3; ++r4) {
                    sequences.push_back({at[r1], at[r2], at[r3], at[r4]});
                }
            }
        }
    }
    return sequences;
}

std::optional<Error> CheckSequence(const Lens& lens, const BounceSequence& sequence) {
    const int count = static_cast<int>(lens.surfaces().size()) + (lens.sensor() ? 1 : 0);
    if (sequence.size() % 2 != 0) {
        return Error{"bad_value", "a sequence has an even number of reflections", ""};
    }
    int previous = -1;
    for (std::size_t i = 0; i < sequence.size(); ++i) {
        const int at = sequence[i];
        if (at < 0 || at >= count) {
            return Error{"bad_value",
                         "surface " + std::to_string(at) + " is not one of the lens's 0.." +
                             std::to_string(count - 1),
                         ""};
        }
        if (at != lens.sensor_index() && lens.surfaces()[static_cast<std::size_t>(at)].is_stop()) {
            return Error{"bad_value",
                         "surface " + std::to_string(at) + " is the stop: it does not reflect", ""};
        }
        // Odd places turn light that goes forward, even ones light that goes back.
        const bool turns_forward_light = i % 2 == 0;
        if (i > 0 && (turns_forward_light ? at <= previous : at >= previous)) {
            return Error{"bad_value",
                         "reflection at " + std::to_string(at) + " cannot follow one at " +
                             std::to_string(previous),
                         ""};
        }
        previous = at;
    }
    return std::nullopt;
}

}  // namespace flare
