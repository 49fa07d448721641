// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/svg_writer.h"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

#include "core/base/check.h"

namespace flare {

void SvgWriter::Open(std::string_view tag, Attributes attributes) {
    Start(tag, attributes);
    text_ += ">\n";
    open_.emplace_back(tag);
}

void SvgWriter::Close() {
    FLARE_CHECK(!open_.empty());
    text_.append(2 * (open_.size() - 1), ' ').append("</").append(open_.back()).append(">\n");
    open_.pop_back();
}

void SvgWriter::Empty(std::string_view tag, Attributes attributes) {
    Start(tag, attributes);
    text_ += "/>\n";
}

void SvgWriter::Text(std::string_view tag, Attributes attributes, std::string_view text) {
    Start(tag, attributes);
    text_.append(">").append(EscapedXml(text)).append("</").append(tag).append(">\n");
}

const std::string& SvgWriter::text() const {
    FLARE_CHECK(open_.empty());
    return text_;
}

void SvgWriter::Start(std::string_view tag, Attributes attributes) {
    text_.append(2 * open_.size(), ' ').append("<").append(tag);
    for (const auto& [name, value] : attributes) {
        text_.append(" ").append(name).append("=\"").append(EscapedXml(value)).append("\"");
    }
}

std::string SvgWriter::Number(double value, int digits) {
    FLARE_CHECK(std::isfinite(value));
    // The largest double has 309 digits before the point.
    std::array<char, 352> buffer{};
    const std::to_chars_result end = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                                   value, std::chars_format::fixed, digits);
    FLARE_CHECK(end.ec == std::errc());
    std::string text(buffer.data(), end.ptr);
    if (text.find('.') != std::string::npos) {
        text.erase(text.find_last_not_of('0') + 1);
        if (text.back() == '.') text.pop_back();
    }
    return text == "-0" ? "0" : text;
}

std::string SvgWriter::Points(const std::vector<Vec2d>& points) {
    std::string text;
    for (const Vec2d& p : points) {
        if (!text.empty()) text += ' ';
        text.append(Number(p.x)).append(",").append(Number(p.y));
    }
    return text;
}

std::string EscapedXml(std::string_view text) {
    std::string out;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (c == '&') {
            out += "&amp;";
        } else if (c == '<') {
            out += "&lt;";
        } else if (c == '>') {
            out += "&gt;";
        } else if (c == '"') {
            out += "&quot;";
        } else if (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') {
            out += '?';
        } else if (text.substr(i, 3) == "\xEF\xBF\xBE" || text.substr(i, 3) == "\xEF\xBF\xBF") {
            out += '?';  // U+FFFE and U+FFFF are no characters
            i += 2;
        } else {
            out += c;
        }
    }
    return out;
}

}  // namespace flare
