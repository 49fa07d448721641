// SPDX-License-Identifier: Apache-2.0
//
// Scan lines of a FlareImage as the chunks of an EXR file: line by line all channels, in the order
// of their names, little-endian; with ZIP, 16 lines rearranged and deflated together. The bytes
// depend on the picture and the options alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/image/exr.h"
#include "core/image/line_deflate.h"

namespace flare {

// The picture as all encoders of its lines share it. The image must outlive it.
struct ExrPlan {
    ExrPlan(const FlareImage& picture, const ExrOptions& how);

    bool zip() const { return options.compression == ExrCompression::kZip; }
    // Bytes of a line's samples, all channels.
    std::size_t line_bytes() const;
    // Of all chunks, without compression.
    std::size_t stored_bytes() const;
    // Chunks of the file: one for 16 lines with ZIP, one a line without.
    int chunk_count() const;

    // A band is what is encoded in one go: 16 lines, or what is left of them at the bottom.
    int band_count() const;
    int band_lines(int band) const;

    const FlareImage& image;
    ExrOptions options;
    std::vector<const float*> channels;    // in the order of their names
    std::vector<std::size_t> first_equal;  // the first channel with the same samples
};

// One band's chunks, one behind the other, each with its line number and its size in front.
struct ExrBand {
    std::vector<unsigned char> bytes;  // of which the first `size` count
    std::size_t size = 0;
    std::uint64_t saturated_pixels = 0;
};

// Encodes one band after the other, with buffers of its own: for one thread at a time.
class ExrBandEncoder {
  public:
    explicit ExrBandEncoder(const ExrPlan& plan);

    void Encode(int band, ExrBand& to);
    // Without compression, where every chunk's size is known beforehand: to the band's place in the
    // file. `chunks` is where the first chunk of all goes. The saturated pixels.
    std::uint64_t StoreInFile(int band, unsigned char* chunks);

  private:
    // One channel's line into units_; true if a value was saturated.
    bool ConvertLine(const float* samples);
    // Returns what lies behind the last byte written.
    unsigned char* Store(int line, int lines, unsigned char* out, bool& saturated);
    std::uint64_t SaturatedIn(int line, int lines) const;
    bool Deflate(int line, int lines, ExrBand& to);
    bool Arrange(int line, int lines);

    const ExrPlan& plan_;
    // A line of a channel in units of two bytes; the first unit is the last of the line before.
    std::vector<std::uint16_t> units_;
    std::vector<unsigned char> arranged_;
    LineDeflater deflater_;
};

}  // namespace flare
