// SPDX-License-Identifier: Apache-2.0
//
// A small strict reader of XML for tests: elements, attributes, text and the five entities;
// anything else, a tag left open or an attribute given twice is not well-formed.
#pragma once

#include <cctype>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace flare::testing {

struct XmlElement {
    std::string name;
    std::map<std::string, std::string> attributes;
    std::string text;  // of the element itself
    std::vector<XmlElement> children;

    std::string Attribute(const std::string& key) const {
        const auto found = attributes.find(key);
        return found == attributes.end() ? "" : found->second;
    }

    // This element and all below it, outermost first, that are of the kind.
    std::vector<const XmlElement*> OfClass(const std::string& kind) const {
        std::vector<const XmlElement*> found;
        if (Attribute("class") == kind) found.push_back(this);
        for (const XmlElement& child : children) {
            for (const XmlElement* element : child.OfClass(kind)) found.push_back(element);
        }
        return found;
    }
};

class XmlReader {
  public:
    // Empty if the text is not one well-formed element.
    static std::optional<XmlElement> Read(std::string_view text) {
        XmlReader reader(text);
        XmlElement root;
        if (!reader.Element(root)) return std::nullopt;
        reader.Spaces();
        if (!reader.rest_.empty()) return std::nullopt;
        return root;
    }

  private:
    explicit XmlReader(std::string_view text) : rest_(text) {}

    bool Take(std::string_view word) {
        if (rest_.substr(0, word.size()) != word) return false;
        rest_.remove_prefix(word.size());
        return true;
    }

    void Spaces() {
        while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front()))) {
            rest_.remove_prefix(1);
        }
    }

    std::string Name() {
        std::size_t size = 0;
        while (size < rest_.size() &&
               (std::isalnum(static_cast<unsigned char>(rest_[size])) || rest_[size] == '-')) {
            ++size;
        }
        const std::string name(rest_.substr(0, size));
        rest_.remove_prefix(size);
        return name;
    }

    // Characters up to `end`, which stays.
    bool Characters(char end, std::string& out) {
        while (!rest_.empty() && rest_.front() != end) {
            const char c = rest_.front();
            if (c == '<' || (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t')) {
                return false;
            }
            if (c != '&') {
                out += c;
                rest_.remove_prefix(1);
            } else if (Take("&amp;")) {
                out += '&';
            } else if (Take("&lt;")) {
                out += '<';
            } else if (Take("&gt;")) {
                out += '>';
            } else if (Take("&quot;")) {
                out += '"';
            } else if (Take("&apos;")) {
                out += '\'';
            } else {
                return false;
            }
        }
        return !rest_.empty();
    }

    bool Element(XmlElement& element) {
        if (!Take("<")) return false;
        element.name = Name();
        if (element.name.empty()) return false;
        while (true) {
            const std::size_t before = rest_.size();
            Spaces();
            if (Take("/>")) return true;
            if (Take(">")) break;
            if (rest_.size() == before) return false;  // no space before an attribute
            const std::string key = Name();
            std::string value;
            if (key.empty() || !Take("=\"") || !Characters('"', value) || !Take("\"")) return false;
            if (!element.attributes.emplace(key, value).second) return false;
        }
        while (!Take("</")) {
            if (!rest_.empty() && rest_.front() == '<') {
                if (!Element(element.children.emplace_back())) return false;
            } else if (!Characters('<', element.text)) {
                return false;
            }
        }
        return Name() == element.name && Take(">");
    }

    std::string_view rest_;
};

}  // namespace flare::testing
