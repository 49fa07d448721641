// SPDX-License-Identifier: Apache-2.0
#include "protocol/codec/base64.h"

#include <cstdint>

namespace flare::wire {
namespace {

constexpr std::string_view kLetters =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

}  // namespace

std::string Base64(std::string_view bytes) {
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t at = 0; at < bytes.size(); at += 3) {
        std::uint32_t word = 0;
        const std::size_t count = std::min<std::size_t>(3, bytes.size() - at);
        for (std::size_t k = 0; k < 3; ++k) {
            const auto byte = k < count ? static_cast<unsigned char>(bytes[at + k]) : 0U;
            word = word << 8 | byte;
        }
        for (std::size_t k = 0; k < 4; ++k)
            text += k <= count ? kLetters[word >> (18 - 6 * k) & 63U] : '=';
    }
    return text;
}

std::optional<std::string> BytesFromBase64(std::string_view text) {
    if (text.size() % 4 != 0) return std::nullopt;
    std::string bytes;
    bytes.reserve(text.size() / 4 * 3);
    for (std::size_t at = 0; at < text.size(); at += 4) {
        std::size_t padding = 0;
        if (at + 4 == text.size()) {
            while (padding < 2 && text[at + 3 - padding] == '=') ++padding;
        }
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t letter = k + padding < 4 ? kLetters.find(text[at + k]) : 0;
            if (letter == std::string_view::npos) return std::nullopt;
            word = word << 6 | static_cast<std::uint32_t>(letter);
        }
        // Bits that no byte takes are zero.
        if ((word & ((1U << (8 * padding)) - 1U)) != 0) return std::nullopt;
        for (std::size_t k = 0; k + padding < 3; ++k)
            bytes += static_cast<char>(word >> (16 - 8 * k) & 255U);
    }
    return bytes;
}

}  // namespace flare::wire
