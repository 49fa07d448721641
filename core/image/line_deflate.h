// SPDX-License-Identifier: Apache-2.0
//
// A zlib stream (RFC 1950) of an EXR chunk's arranged bytes, several times faster than a general
// compressor. It looks for nothing but what such bytes have: runs of one value, and segments (the
// bytes of one channel's line) that repeat the one a fixed distance back, as a layer does that is
// the whole picture. The rest is Huffman coded. For differences between half floats of a flare that
// comes out no larger than with a search for matches, which are accidents there.
//
// A LineDeflater keeps its buffers: one thread at a time. The bytes depend on the input alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace flare {

class LineDeflater {
  public:
    // Bytes behind `room` that may be overwritten.
    static constexpr std::size_t kSlack = 8;

    // `count` is a multiple of `segment`, of which the last `count / 2` bytes begin a new kind (low
    // and high bytes are coded apart). `repeat` is the distance in bytes at which segments may
    // repeat, a multiple of `segment`; 0 or one above 32768 for none. Returns the size of the
    // stream, or 0 where it does not fit into `room` bytes.
    std::size_t Deflate(const unsigned char* bytes, std::size_t count, std::size_t segment,
                        std::size_t repeat, unsigned char* to, std::size_t room);

  private:
    struct Copy {
        std::size_t at, length, distance;
    };
    class Block;

    void FindCopies(const unsigned char* bytes, std::size_t begin, std::size_t end,
                    std::size_t segment, std::size_t repeat);
    void FindRuns(const unsigned char* bytes, std::size_t begin, std::size_t end);

    std::vector<Copy> copies_;
};

// Checksum of RFC 1950.
std::uint32_t Adler32(const unsigned char* bytes, std::size_t count);

}  // namespace flare
