// SPDX-License-Identifier: Apache-2.0
//
// A bounce sequence names a path through the lens by the surfaces that reflect, in the order the
// light meets them. [] is the direct path; a two-reflection ghost is [r1, r2] with r1 > r2.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/optics/lens.h"

namespace flare {

using BounceSequence = std::vector<int>;

// Surfaces that reflect, from the front. A surface with the same medium on both sides (and no
// coating can change that) reflects nothing and is left out, as is the stop. `with_sensor` adds the
// sensor if the lens has a reflecting one.
std::vector<int> ReflectingSurfaces(const Lens& lens, bool with_sensor);

// All two-reflection sequences of the lens in lexical order.
std::vector<BounceSequence> TwoReflectionSequences(const Lens& lens, bool with_sensor = false);

// All four-reflection sequences r1 > r2 < r3 > r4, in lexical order: about n^4 / 6 of them for n
// reflecting surfaces (10: 1 695, 27: 102 726).
std::vector<BounceSequence> FourReflectionSequences(const Lens& lens, bool with_sensor = false);

// Is it an even number of reflections at real surfaces, each on the other side of the last one? The
// error's `where` is left to the caller.
std::optional<Error> CheckSequence(const Lens& lens, const BounceSequence& sequence);

}  // namespace flare
