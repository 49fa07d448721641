// SPDX-License-Identifier: Apache-2.0
//
// Other encodings of a FlareImage: an 8-bit PNG to look at, and raw half planes for game tools.
// Both depend on the image alone, not on the number of threads. Safe from any thread. The image
// must have a pixel and a plane.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/parallel.h"
#include "core/image/flare_image.h"

namespace flare {

// Tone-mapped sRGB PNG of the planes R, G, B (of the first layer that has them, where the root has
// none), or else, as grey, of the mean of all planes in the first plane's layer (spectral images).
// Exposure is set so that the 99.5th percentile of the pixels with light (by their largest channel)
// is at 80 % grey, where a soft shoulder begins; it is for looking, not for measuring. A black
// image is black; NaN and negative values are black, infinite ones white.
std::string EncodePng(const FlareImage& image);

// application/x-flare-half: a 64-byte little-endian header (magic "FLRH", u32 version 1, u32 width,
// u32 height, u32 channels, u32 bytes of names, zeros), the channel names, each ended by a zero
// byte, then one plane of half floats a channel, saturated at 65504.
struct HalfPlanes {
    std::string bytes;
    std::uint64_t saturated_pixels = 0;  // with a value beyond +-65504
};
// `memory` is used again for the bytes, whatever it holds.
HalfPlanes EncodeHalfPlanes(const FlareImage& image, ThreadPool& threads, std::string memory = {});

}  // namespace flare
