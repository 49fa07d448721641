// SPDX-License-Identifier: Apache-2.0
//
// Parts of a request that stand on their own: the picture's frame, the iris, and the choice of a
// lens. For the codecs of whole messages.
#pragma once

#include <optional>
#include <string>

#include "protocol/codec/reader.h"
#include "protocol/wire/flare_request.h"

namespace flare::wire {

bool ReadImage(Reader& reader, const JsonView& at, Image& image);
// Is the picture small enough, with so many channels a layer? `at` is the image's place.
bool CheckPictureSize(Reader& reader, const JsonView& at, const Image& image, std::size_t channels);
bool ReadIris(Reader& reader, const JsonView& at, Iris& iris);

// Which lens, in which state: the members "lens" or "prescription", "coatings" and "f_number" of a
// message.
struct LensChoice {
    std::optional<std::string> lens;
    std::optional<JsonTree> prescription;
    bool bare_glass = false;
    std::optional<double> f_number;
};
bool ReadLensChoice(Reader& reader, const JsonView& root, LensChoice& choice);

}  // namespace flare::wire
