// SPDX-License-Identifier: Apache-2.0
//
// The mask image of a request as a picture of the stop: the image stands in the middle of a square,
// its top up, as seen from behind the camera; beyond it the stop is dark. Errors have `where`.
#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/optics/stop_picture.h"
#include "protocol/wire/flare_request.h"

namespace flare {

Result<std::shared_ptr<const StopPicture>> MaskFromWire(const wire::IrisMask& mask);

}  // namespace flare
