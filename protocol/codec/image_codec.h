// SPDX-License-Identifier: Apache-2.0
//
// Parts of a request that stand on their own: the picture's frame and the iris.
#pragma once

#include <cstddef>

#include "protocol/codec/reader.h"
#include "protocol/wire/flare_request.h"

namespace flare::wire {

bool ReadImage(Reader& reader, const JsonView& at, Image& image);
// Is the picture small enough, with so many channels a layer? `at` is the image's place.
bool CheckPictureSize(Reader& reader, const JsonView& at, const Image& image, std::size_t channels);
bool ReadIris(Reader& reader, const JsonView& at, Iris& iris);

}  // namespace flare::wire
