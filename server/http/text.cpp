// SPDX-License-Identifier: Apache-2.0
#include "server/http/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace flare {
namespace {

char Lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

int HexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    const char lower = Lower(c);
    return lower >= 'a' && lower <= 'f' ? lower - 'a' + 10 : -1;
}

}  // namespace

bool EqualIgnoringCase(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](char x, char y) { return Lower(x) == Lower(y); });
}

std::string_view TrimSpace(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::vector<std::string_view> Split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (;;) {
        const std::size_t end = text.find(separator);
        parts.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return parts;
        text.remove_prefix(end + 1);
    }
}

std::optional<std::string> DecodePercent(std::string_view text) {
    std::string decoded;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded.push_back(text[i]);
            continue;
        }
        if (text.size() - i < 3) return std::nullopt;
        const int high = HexDigit(text[i + 1]), low = HexDigit(text[i + 2]);
        if (high < 0 || low < 0) return std::nullopt;
        decoded.push_back(static_cast<char>(high * 16 + low));
        i += 2;
    }
    return decoded;
}

Result<Query> ParseQuery(std::string_view text) {
    Query query;
    if (text.empty()) return query;
    for (const std::string_view part : Split(text, '&')) {
        const std::size_t equals = part.find('=');
        const auto name = DecodePercent(part.substr(0, equals));
        if (!name || name->empty()) {
            return Error{"bad_query", "the query holds '" + std::string(part) + "', not name=value",
                         "?"};
        }
        if (equals == std::string_view::npos) {
            return Error{"bad_query", "the parameter '" + *name + "' has no value", "?" + *name};
        }
        const auto value = DecodePercent(part.substr(equals + 1));
        if (!value) return Error{"bad_query", "broken %-escape in the value", "?" + *name};
        if (!query.emplace(*name, *value).second) {
            return Error{"bad_query", "the parameter '" + *name + "' is given twice", "?" + *name};
        }
    }
    return query;
}

std::optional<double> ParseNumber(std::string_view text) {
    double value = 0.0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
    if (!std::isfinite(value)) return std::nullopt;
    return value;
}

}  // namespace flare
