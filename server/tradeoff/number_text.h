// SPDX-License-Identifier: Apache-2.0
//
// Numbers as text that reads back to the same number, whatever the locale.
#pragma once

#include <array>
#include <charconv>
#include <cmath>
#include <string>

namespace flare {

inline std::string NumberText(double value) {
    if (std::isnan(value)) return "nan";
    if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
    std::array<char, 32> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    return {text.data(), end};
}

// With this many significant digits.
inline std::string NumberText(double value, int digits) {
    if (!std::isfinite(value)) return NumberText(value);
    std::array<char, 48> text{};
    const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                   std::chars_format::general, digits)
                         .ptr;
    return {text.data(), end};
}

}  // namespace flare
