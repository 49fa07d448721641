// SPDX-License-Identifier: Apache-2.0
//
// Layout of a single-part file (OpenEXR File Layout): magic, version and flags, then attributes,
// each a name and a type ended by a zero byte, a size and that many bytes; an empty name ends the
// header. Numbers are little-endian.
#include "core/image/exr_prescan.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/image/exr.h"

namespace flare {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kVersionMask = 0xff, kVersion = 2;
constexpr std::uint32_t kTiledFlag = 0x200, kLongNamesFlag = 0x400;
constexpr std::size_t kMaxName = 255;
// One chunk (lines compressed together, or a tile) of one channel in OpenEXR's own buffers.
constexpr std::uint64_t kMaxChunkBytes = std::uint64_t{1} << 28;
// Scan lines a chunk, by the code of the compression.
constexpr std::array<std::uint64_t, 10> kLinesInChunk = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};

Error BadImage(std::string message, std::size_t at) {
    return {"bad_image", std::move(message), "byte " + std::to_string(at)};
}

class Cursor {
  public:
    Cursor(std::string_view bytes, std::size_t at) : bytes_(bytes), at_(at) {}

    std::size_t at() const { return at_; }
    std::size_t left() const { return bytes_.size() - at_; }

    std::optional<std::uint32_t> U32() {
        if (left() < 4) return std::nullopt;
        std::uint32_t value = 0;
        for (unsigned k = 0; k < 4; ++k) {
            value |= std::uint32_t{static_cast<unsigned char>(bytes_[at_ + k])} << (8 * k);
        }
        at_ += 4;
        return value;
    }

    // A name up to its zero byte, which is skipped.
    std::optional<std::string_view> Name() {
        const std::size_t end = bytes_.substr(at_, kMaxName + 1).find('\0');
        if (end == std::string_view::npos) return std::nullopt;
        const std::string_view name = bytes_.substr(at_, end);
        at_ += end + 1;
        return name;
    }

    std::string_view Bytes(std::size_t count) {
        const std::string_view taken = bytes_.substr(at_, count);
        at_ += count;
        return taken;
    }

  private:
    std::string_view bytes_;
    std::size_t at_;
};

// What the header claims; nothing where it says nothing.
struct Claims {
    std::optional<std::uint64_t> width, height;
    std::optional<std::uint64_t> channels;
    std::optional<std::uint64_t> lines_in_chunk;
    std::optional<std::uint64_t> tile_pixels;
};

std::int64_t Signed(std::uint32_t bits) {
    return static_cast<std::int32_t>(bits);
}

// Fills in what one attribute claims; returns false where it is malformed or stands twice.
bool ReadClaim(std::string_view name, std::string_view value, Claims& claims) {
    Cursor cursor(value, 0);
    if (name == "dataWindow") {
        if (claims.width || value.size() != 16) return false;
        const std::int64_t x0 = Signed(*cursor.U32()), y0 = Signed(*cursor.U32());
        const std::int64_t x1 = Signed(*cursor.U32()), y1 = Signed(*cursor.U32());
        if (x1 < x0 || y1 < y0) return false;
        claims.width = static_cast<std::uint64_t>(x1 - x0 + 1);
        claims.height = static_cast<std::uint64_t>(y1 - y0 + 1);
    } else if (name == "channels") {
        if (claims.channels) return false;
        std::uint64_t count = 0;
        while (true) {
            const std::optional<std::string_view> channel = cursor.Name();
            if (!channel) return false;
            if (channel->empty()) break;
            if (cursor.left() < 16) return false;
            cursor.Bytes(16);
            ++count;
        }
        claims.channels = count;
    } else if (name == "compression") {
        if (claims.lines_in_chunk || value.size() != 1) return false;
        const auto code = static_cast<unsigned char>(value[0]);
        if (code >= kLinesInChunk.size()) return false;
        claims.lines_in_chunk = kLinesInChunk[code];
    } else if (name == "tiles") {
        if (claims.tile_pixels || value.size() != 9) return false;
        const std::uint64_t x = *cursor.U32(), y = *cursor.U32();
        if (x == 0 || y == 0) return false;
        claims.tile_pixels = x * y;
    }
    return true;
}

std::optional<Error> CheckClaims(const Claims& claims, bool tiled, std::size_t at) {
    if (!claims.width || !claims.channels || !claims.lines_in_chunk) {
        return BadImage("the EXR header lacks a data window, a channel list or a compression", at);
    }
    if (*claims.channels == 0) return BadImage("the EXR has no channel", at);
    if (tiled && !claims.tile_pixels) return BadImage("the EXR header lacks a tile size", at);
    const std::uint64_t w = *claims.width, h = *claims.height;  // each at most 2^32
    if (w > kMaxExrPixels || h > kMaxExrPixels || w * h > kMaxExrPixels) {
        return BadImage("an EXR of " + std::to_string(w) + " x " + std::to_string(h) +
                            " pixels is above the limit of " + std::to_string(kMaxExrPixels),
                        at);
    }
    if (w * h * *claims.channels > kMaxExrValues) {
        return BadImage("an EXR of " + std::to_string(w) + " x " + std::to_string(h) +
                            " pixels and " + std::to_string(*claims.channels) +
                            " channels is above the limit of " + std::to_string(kMaxExrValues) +
                            " values",
                        at);
    }
    const std::uint64_t chunk_pixels = tiled ? *claims.tile_pixels : w * *claims.lines_in_chunk;
    if (chunk_pixels > kMaxChunkBytes / (4 * *claims.channels)) {
        return BadImage("the EXR's tiles or blocks of lines are too large", at);
    }
    return std::nullopt;
}

}  // namespace

std::optional<Error> PrescanExr(std::string_view bytes) {
    Cursor cursor(bytes, 0);
    if (cursor.U32() != kMagic) return BadImage("these bytes are no OpenEXR file", 0);
    const std::optional<std::uint32_t> version = cursor.U32();
    if (!version) return BadImage("the EXR ends inside its header", bytes.size());
    const std::uint32_t flags = *version & ~kVersionMask;
    if ((*version & kVersionMask) != kVersion || (flags & ~(kTiledFlag | kLongNamesFlag)) != 0) {
        return BadImage("only single-part scan-line and tiled EXR files are read", 4);
    }
    Claims claims;
    while (true) {
        const std::size_t start = cursor.at();
        const std::optional<std::string_view> name = cursor.Name();
        if (!name) return BadImage("the EXR's header ends inside a name", start);
        if (name->empty()) break;
        const std::optional<std::string_view> type = cursor.Name();
        const std::optional<std::uint32_t> size = type ? cursor.U32() : std::nullopt;
        if (!size || *size > cursor.left()) {
            return BadImage("an attribute of the EXR runs past the end", start);
        }
        if (!ReadClaim(*name, cursor.Bytes(*size), claims)) {
            return BadImage("the EXR's attribute " + std::string(*name) + " is malformed", start);
        }
    }
    return CheckClaims(claims, (flags & kTiledFlag) != 0, cursor.at());
}

}  // namespace flare
