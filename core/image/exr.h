// SPDX-License-Identifier: Apache-2.0
//
// FlareImage to and from OpenEXR bytes: single part, scan lines, one channel a plane, under the
// plane's own name ("R", "ghosts.R", "ghosts.S0.587,5618nm"). Output depends on the image and
// options alone: no time stamp, and the same bytes with any number of threads. Writing uses the
// caller's threads and takes memory for the file (at most its size without compression) and, with
// ZIP, a band of 16 lines a thread. Safe from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/parallel.h"
#include "core/base/result.h"
#include "core/image/flare_image.h"

namespace flare {

enum class ExrCompression { kNone, kZip };
enum class ExrPixel { kHalf, kFloat };

struct ExrOptions {
    ExrCompression compression = ExrCompression::kZip;
    ExrPixel pixel = ExrPixel::kHalf;
};

struct ExrBytes {
    std::string bytes;
    // Pixels with a value that the pixel type cannot hold, set to its largest (half: +-65504).
    std::uint64_t saturated_pixels = 0;
};

// The image must have at least one pixel and one plane, planes of the data window's size with
// distinct names, and no attribute under a name OpenEXR keeps for itself ("channels", ...):
// anything else is a broken invariant. NaN is written as it is; a renderer checks its own planes.
// `memory` is used again for the bytes, whatever it holds.
ExrBytes EncodeExr(const FlareImage& image, const ExrOptions& options, ThreadPool& threads,
                   std::string memory = {});

// What DecodeExr refuses to make room for.
inline constexpr std::size_t kMaxExrPixels = std::size_t{1} << 27;
inline constexpr std::size_t kMaxExrValues = std::size_t{1} << 29;  // pixels times channels

// Reads any single-part scan-line or tiled EXR (of several levels the finest), half, float or uint,
// channels in the order of the file. Strings and numbers of the header become attributes; `rec709`
// says whether the header states those chromaticities, `chromaticities` holds any others. Error
// code "bad_image"; sizes are checked before memory is taken.
Result<FlareImage> DecodeExr(std::string_view bytes);

}  // namespace flare
