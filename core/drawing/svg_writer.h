// SPDX-License-Identifier: Apache-2.0
//
// Writes SVG text: elements, escaped text, numbers. The same calls give the same bytes everywhere:
// numbers do not follow the locale. Elements must be closed in the order of a stack. Not for two
// threads at once.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/vec.h"

namespace flare {

class SvgWriter {
  public:
    using Attributes = std::initializer_list<std::pair<std::string_view, std::string>>;

    void Open(std::string_view tag, Attributes attributes);
    void Close();
    void Empty(std::string_view tag, Attributes attributes);
    void Text(std::string_view tag, Attributes attributes, std::string_view text);

    // Every element must be closed.
    const std::string& text() const;

    // Up to `digits` places behind the point, without trailing zeros. Requires a finite value.
    static std::string Number(double value, int digits = 4);
    // "x,y x,y ..."
    static std::string Points(const std::vector<Vec2d>& points);

  private:
    void Start(std::string_view tag, Attributes attributes);

    std::string text_;
    std::vector<std::string> open_;
};

// `text` as it may stand in XML 1.0 text or in an attribute. What XML cannot hold becomes '?'.
std::string EscapedXml(std::string_view text);

}  // namespace flare
