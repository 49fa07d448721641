// SPDX-License-Identifier: Apache-2.0
//
// Images of a request. A mask becomes a picture of the stop: the image stands in the middle of a
// square, its top up, as seen from behind the camera; beyond it the stop is dark. The shape of a
// light becomes shares of its light. Errors have `where`.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/optics/stop_picture.h"
#include "core/render/source_picture.h"
#include "protocol/wire/flare_request.h"

namespace flare {

Result<std::shared_ptr<const StopPicture>> MaskFromWire(const wire::IrisMask& mask);

// Of light number `light`, as the bytes of a PNG.
Result<std::shared_ptr<const SourcePicture>> ShapeFromWire(const std::string& png,
                                                           std::size_t light);

}  // namespace flare
