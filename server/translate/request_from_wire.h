// SPDX-License-Identifier: Apache-2.0
//
// From the words of the wire to those of the core: the lens is looked up or built, zoomed and
// focused, lengths and enums are put into the core's types. Nothing is invented here; defaults were
// filled in by the codec.
#pragma once

#include <array>

#include "core/base/fingerprint.h"
#include "core/base/result.h"
#include "core/render/flare_request.h"
#include "protocol/wire/flare_request.h"
#include "server/lens_library.h"

namespace flare {

// A direction may have any length on the wire. One whose square a double cannot hold is brought
// near length 1 by a power of two, which changes no digit of the ratios.
Vec3d DirectionFromWire(const std::array<double, 3>& direction);

// Errors of the lens stand at "/lens", "/prescription..." or "/coatings..."; a state outside the
// lens's range is clamped, and state_clamped says so.
Result<FlareRequest> RequestFromWire(const wire::FlareRequest& request, const LensLibrary& library);

// Names what was asked for: equal for two bodies that mean the same, however they are written, and
// different if any decoded value or the lens's own content is. `translated` is what RequestFromWire
// made of the request.
Fingerprint RequestHash(const wire::FlareRequest& request, const FlareRequest& translated);

}  // namespace flare
