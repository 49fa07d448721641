// SPDX-License-Identifier: Apache-2.0
//
// A first look at the header of an EXR of unknown origin. OpenEXR takes memory by what the header
// claims, before it finds out that the bytes are not there; this reads the claims alone and refuses
// what is out of bounds. It links no library and allocates nothing of the file's choosing.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/result.h"

namespace flare {

// The reason to refuse the file (code "bad_image"), or nothing. A file that passes may still be
// broken, but claims no attribute beyond its own end and no size beyond the limits in exr.h.
std::optional<Error> PrescanExr(std::string_view bytes);

}  // namespace flare
