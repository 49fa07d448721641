// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/qsb.h"

#include <charconv>
#include <cstdio>

namespace flare {
namespace {

std::optional<std::uint32_t> Hex(std::string_view digits) {
    std::uint32_t value = 0;
    const auto [end, failed] =
        std::from_chars(digits.data(), digits.data() + digits.size(), value, 16);
    if (failed != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    return value;
}

}  // namespace

std::string QsbSetUp(std::optional<int> index_count) {
    // MDR0: bits 0 and 1 quadrature times four, bits 4 and 5 the index: off, or load the preset.
    char preset[40] = "W0303\n";
    if (index_count) {
        std::snprintf(preset, sizeof preset, "W08%08X\nW0313\n",
                      static_cast<unsigned>(*index_count));
    }
    return std::string("W1505\nW0000\n") + preset + "W0C0001\nR14\n";
}

Result<QsbReply> DecodeQsb(std::string_view line) {
    const Error bad{"bad_data", "not an answer of a QSB", ""};
    if (line.ends_with('!')) line.remove_suffix(1);
    if (line.size() != 11 && line.size() != 19) return bad;
    QsbReply reply;
    reply.kind = static_cast<char>(line[0] | 0x20);
    if (std::string_view("rwse").find(reply.kind) == std::string_view::npos) return bad;
    const std::optional<std::uint32_t> number = Hex(line.substr(1, 2));
    const std::optional<std::uint32_t> data = Hex(line.substr(3, 8));
    if (!number || !data) return bad;
    reply.register_number = static_cast<int>(*number);
    reply.data = *data;
    if (line.size() == 19) {
        reply.stamp = Hex(line.substr(11));
        if (!reply.stamp) return bad;
    }
    return reply;
}

std::int64_t QsbCounter::Follow(std::uint32_t data) {
    if (!last_) {
        count_ = static_cast<std::int32_t>(data);
    } else {
        count_ += static_cast<std::int32_t>(data - *last_);
    }
    last_ = data;
    return count_;
}

}  // namespace flare
