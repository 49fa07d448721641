// SPDX-License-Identifier: Apache-2.0
//
// The bytes of an EXR file up to its table of chunk offsets: magic number, version, attributes.
// What EncodeExr refuses is a broken invariant here too.
#pragma once

#include <string>

#include "core/image/exr.h"

namespace flare {

std::string ExrHeader(const FlareImage& image, const ExrOptions& options);

}  // namespace flare
