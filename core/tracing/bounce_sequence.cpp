// SPDX-License-Identifier: Apache-2.0
#include "core/tracing/bounce_sequence.h"

namespace flare {

std::vector<BounceSequence> TwoReflectionSequences(const Lens& lens) {
    std::vector<int> reflecting;
    for (int i = 0; i < static_cast<int>(lens.surfaces().size()); ++i) {
        const LensSurface& surface = lens.surfaces()[static_cast<std::size_t>(i)];
        if (surface.is_stop() || lens.MediumBefore(i) == lens.MediumBehind(i)) continue;
        reflecting.push_back(i);
    }
    std::vector<BounceSequence> sequences;
    for (std::size_t first = 0; first < reflecting.size(); ++first) {
        for (std::size_t second = 0; second < first; ++second) {
            sequences.push_back({reflecting[first], reflecting[second]});
        }
    }
    return sequences;
}

std::optional<Error> CheckSequence(const Lens& lens, const BounceSequence& sequence) {
    const int count = static_cast<int>(lens.surfaces().size());
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
        if (lens.surfaces()[static_cast<std::size_t>(at)].is_stop()) {
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
