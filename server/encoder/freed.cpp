// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/freed.h"

namespace flare {

std::uint8_t FreeDChecksum(std::span<const std::uint8_t> bytes) {
    unsigned sum = 0x40;
    for (const std::uint8_t byte : bytes) sum -= byte;
    return static_cast<std::uint8_t>(sum & 0xffU);
}

Result<FreeDMessage> DecodeFreeD(std::span<const std::uint8_t> bytes) {
    if (bytes.size() != kFreeDBytes) {
        return Error{"bad_data", std::to_string(bytes.size()) + " bytes are no FreeD message", ""};
    }
    if (bytes[0] != 0xd1) return Error{"bad_data", "not the FreeD message D1", "byte 1"};
    if (FreeDChecksum(bytes.first(kFreeDBytes - 1)) != bytes.back()) {
        return Error{"bad_data", "the FreeD checksum is wrong", "byte 29"};
    }
    const auto three = [&](std::size_t at) {
        return static_cast<std::uint32_t>(bytes[at] << 16 | bytes[at + 1] << 8 | bytes[at + 2]);
    };
    FreeDMessage message;
    message.camera = bytes[1];
    message.zoom = three(20);
    message.focus = three(23);
    message.spare = static_cast<std::uint16_t>(bytes[26] << 8 | bytes[27]);
    return message;
}

}  // namespace flare
