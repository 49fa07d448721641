// SPDX-License-Identifier: Apache-2.0
//
// Takes the built-in tables apart: lines, columns, numbers. They are part of the program, so text
// that is not a number is a broken invariant.
#pragma once

#include <algorithm>
#include <charconv>
#include <string_view>
#include <vector>

#include "core/base/check.h"

namespace flare {

inline std::vector<std::string_view> SplitText(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(separator), text.size());
        parts.push_back(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return parts;
}

// Without the lines that start with '#'.
inline std::vector<std::string_view> TableLines(std::string_view text) {
    std::vector<std::string_view> lines;
    for (const std::string_view line : SplitText(text, '\n')) {
        if (!line.empty() && line.front() != '#') lines.push_back(line);
    }
    return lines;
}

inline double NumberIn(std::string_view text) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    FLARE_CHECK(error == std::errc() && end == text.data() + text.size());
    return value;
}

inline std::vector<double> NumbersIn(std::string_view text, char separator) {
    std::vector<double> numbers;
    for (const std::string_view part : SplitText(text, separator)) {
        numbers.push_back(NumberIn(part));
    }
    return numbers;
}

}  // namespace flare
