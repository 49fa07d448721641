// SPDX-License-Identifier: Apache-2.0
//
// From the words of the wire to those of the core: the lens is looked up or built, lengths and
// enums are put into the core's types. Nothing is invented here; defaults were filled in by the
// codec.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "core/base/fingerprint.h"
#include "core/base/result.h"
#include "core/optics/lens.h"
#include "core/render/flare_request.h"
#include "protocol/wire/flare_request.h"
#include "server/lens_library.h"

namespace flare {

// The lens of a message: from the library by name, or built from an inline prescription, its glass
// bare if asked. Errors stand at "/lens" or inside "/prescription".
Result<std::shared_ptr<const Lens>> LensFromWire(const std::optional<std::string>& name,
                                                 const std::optional<wire::JsonTree>& prescription,
                                                 bool bare_glass, const LensLibrary& library);

// A direction may have any length on the wire. One whose square a double cannot hold is brought
// near length 1 by a power of two, which changes no digit of the ratios.
Vec3d DirectionFromWire(const std::array<double, 3>& direction);

Result<FlareRequest> RequestFromWire(const wire::FlareRequest& request, const LensLibrary& library);

// Names what was asked for: equal for two bodies that mean the same, however they are written, and
// different if any decoded value or the lens's own content is. `lens` is the translated request's.
Fingerprint RequestHash(const wire::FlareRequest& request, const Lens& lens);

}  // namespace flare
