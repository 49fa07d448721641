// SPDX-License-Identifier: Apache-2.0
//
// A request may name its iris's mask and the shapes of its lights as files, "iris": {"mask":
// "heart.png"}, {"mask": {"file": "heart.png", ...}} or "lights": [{"shape": "neon.png", ...}]: a
// PNG or an EXR, relative to the request's own folder. The client puts the image itself in its
// place, an EXR as a PNG of 16 bits, since a daemon opens no files that a client names.
#pragma once

#include <string>

#include "core/base/result.h"

namespace flare::cli {

// `body` as it is to be sent; `request` is the file it came from, or "-". A body that names no file
// comes back as it is.
Result<std::string> WithImagesInside(const std::string& body, const std::string& request);

}  // namespace flare::cli
