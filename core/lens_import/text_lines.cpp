// SPDX-License-Identifier: Apache-2.0
#include "core/lens_import/text_lines.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace flare {

namespace {

constexpr std::string_view kBlanks = " \t\v\f";
constexpr std::size_t kMaxQuotedBytes = 60;

std::string_view Trimmed(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos) return {};
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

char Upper(char c) {
    return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
}
char Lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

std::vector<TextLine> LinesOf(std::string_view text) {
    std::vector<TextLine> lines;
    for (int number = 1; !text.empty(); ++number) {
        const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
        const std::string_view line = Trimmed(text.substr(0, end));
        if (!line.empty()) lines.push_back({number, line});
        const bool both = text.substr(end, 2) == "\r\n";
        text.remove_prefix(std::min(end + (both ? 2 : 1), text.size()));
    }
    return lines;
}

std::string LinePlace(int number) {
    return "line " + std::to_string(number);
}

std::vector<std::string_view> WordsOf(std::string_view text, std::string_view also) {
    const std::string between = std::string(kBlanks) + std::string(also);
    std::vector<std::string_view> words;
    while (true) {
        const std::size_t begin = text.find_first_not_of(between);
        if (begin == std::string_view::npos) return words;
        text.remove_prefix(begin);
        const std::size_t end = std::min(text.find_first_of(between), text.size());
        words.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
}

std::string UpperCase(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), Upper);
    return out;
}

std::string LowerCase(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(), Lower);
    return out;
}

std::optional<double> NumberIn(std::string_view word) {
    if (word.size() > 1 && word.front() == '+' && word[1] != '-') word.remove_prefix(1);
    constexpr std::size_t kMaxDigits = 64;
    if (word.empty() || word.size() > kMaxDigits) return std::nullopt;
    std::string plain(word);
    if (const std::size_t exponent = plain.find_first_of("dD"); exponent != std::string::npos) {
        plain[exponent] = 'e';
    }
    double value = 0.0;
    const char* end = plain.data() + plain.size();
    const auto [stopped, fault] = std::from_chars(plain.data(), end, value);
    if (fault != std::errc() || stopped != end || !std::isfinite(value)) return std::nullopt;
    return value;
}

Result<double> RequireNumber(std::string_view word, const std::string& what, int line) {
    if (const std::optional<double> value = NumberIn(word)) return *value;
    return Error{"bad_lens", what + " is " + Quoted(word) + ", which is no finite number",
                 LinePlace(line)};
}

std::optional<double> FNumberIn(std::string_view text) {
    for (std::size_t i = 0; i + 1 < text.size(); ++i) {
        if (Lower(text[i]) != 'f') continue;
        const bool inside_word = i > 0 && Lower(text[i - 1]) >= 'a' && Lower(text[i - 1]) <= 'z';
        std::size_t at = text.find_first_not_of(' ', i + 1);
        if (inside_word || at == std::string_view::npos || text[at] != '/') continue;
        at = text.find_first_not_of(' ', at + 1);
        if (at == std::string_view::npos) continue;
        std::size_t end = at;
        while (end < text.size() && ((text[end] >= '0' && text[end] <= '9') || text[end] == '.')) {
            ++end;
        }
        while (end > at && text[end - 1] == '.') --end;
        const std::optional<double> value = NumberIn(text.substr(at, end - at));
        if (value && *value > 0.0) return value;
    }
    return std::nullopt;
}

std::string Quoted(std::string_view text) {
    std::string out = "\"";
    for (const char c : text.substr(0, kMaxQuotedBytes)) {
        const auto byte = static_cast<unsigned char>(c);
        out += byte < 0x20 || byte >= 0x7f ? '?' : c;
    }
    return out + (text.size() > kMaxQuotedBytes ? "...\"" : "\"");
}

}  // namespace flare
