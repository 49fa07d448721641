// SPDX-License-Identifier: Apache-2.0
//
// nlohmann-json's event parser does the lexing (it works without recursion and never builds a
// tree); the builder below lays the events down flat and watches the limits. Returning false from
// an event ends the parse, so a hostile text costs no more than the part that was read.
#include "protocol/codec/json_document.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "protocol/limits.h"

namespace flare::wire {

void AppendPointerToken(std::string& pointer, std::string_view token) {
    pointer += '/';
    for (const char c : token) {
        if (c == '~') {
            pointer += "~0";
        } else if (c == '/') {
            pointer += "~1";
        } else {
            pointer += c;
        }
    }
}

class JsonBuilder final : public nlohmann::json_sax<nlohmann::json> {
  public:
    explicit JsonBuilder(JsonDocument& document) : document_(document) {}

    Refusal refusal;

    bool null() override { return Append(JsonKind::kNull) != nullptr; }
    bool boolean(bool value) override {
        JsonDocument::Node* node = Append(JsonKind::kBoolean);
        if (node) node->boolean = value;
        return node;
    }
    bool number_integer(number_integer_t value) override {
        return Number(static_cast<double>(value));
    }
    bool number_unsigned(number_unsigned_t value) override {
        return Number(static_cast<double>(value));
    }
    bool number_float(number_float_t value, const string_t&) override { return Number(value); }
    bool string(string_t& value) override {
        JsonDocument::Node* node = Append(JsonKind::kString);
        if (!node) return false;
        const bool image = JsonView(&document_, last_).key() == "png_base64";
        const std::size_t most = image ? limits::kMaskTextBytes : limits::kStringBytes;
        if (value.size() > most) {
            return Refuse("limit", "the string is longer than " + std::to_string(most) + " bytes");
        }
        node->text_begin = Store(value);
        node->text_size = static_cast<std::uint32_t>(value.size());
        return true;
    }
    bool binary(binary_t&) override { return false; }  // not in JSON texts

    bool start_object(std::size_t) override { return Open(JsonKind::kObject); }
    bool start_array(std::size_t) override { return Open(JsonKind::kArray); }
    bool end_object() override { return Close(); }
    bool end_array() override { return Close(); }

    bool key(string_t& name) override {
        last_ = open_.back();
        if (name.size() > limits::kJsonKeyBytes) {
            return Refuse("limit", "a member's name is longer than " +
                                       std::to_string(limits::kJsonKeyBytes) + " bytes");
        }
        const JsonDocument::Node& object = document_.nodes_[open_.back()];
        if (object.children >= limits::kJsonMembers) {
            return Refuse("limit", "an object has more than " +
                                       std::to_string(limits::kJsonMembers) + " members");
        }
        for (std::optional<JsonView> child = FirstChildOfOpen(); child;) {
            if (child->key() == name) {
                refusal = {"duplicate_key", "the member \"" + name + "\" stands twice",
                           child->Pointer()};
                return false;
            }
            const std::uint32_t next = document_.nodes_[child->index_].end;
            if (next >= document_.nodes_.size()) break;
            child = JsonView(&document_, next);
        }
        key_begin_ = Store(name);
        key_size_ = static_cast<std::uint32_t>(name.size());
        return true;
    }

    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::json::exception& error) override {
        if (error.id == kNumberOverflow) {
            // The value has no node yet: its place is that of the node it would have become.
            Append(JsonKind::kNumber);
            return Refuse("bad_value", "the number is too large for a double");
        }
        refusal = {"bad_json", Plain(error.what()), "byte " + std::to_string(position)};
        return false;
    }

  private:
    static constexpr int kNumberOverflow = 406;  // nlohmann-json's own number for it

    // "[json.exception.parse_error.101] parse error at line 1, column 5: ..." without the brackets.
    static std::string Plain(const std::string& what) {
        const std::size_t end = what.find("] ");
        return end == std::string::npos ? what : what.substr(end + 2);
    }

    bool Refuse(const char* code, std::string message) {
        refusal = {code, std::move(message), JsonView(&document_, last_).Pointer()};
        return false;
    }

    std::uint32_t Store(const std::string& text) {
        const std::size_t begin = document_.text_.size();
        document_.text_ += text;
        return static_cast<std::uint32_t>(begin);
    }

    std::optional<JsonView> FirstChildOfOpen() const {
        if (document_.nodes_[open_.back()].children == 0) return std::nullopt;
        return JsonView(&document_, open_.back() + 1);
    }

    bool Number(double value) {
        JsonDocument::Node* node = Append(JsonKind::kNumber);
        if (!node) return false;
        if (!std::isfinite(value)) return Refuse("bad_value", "the number is not finite");
        node->number = value;
        return true;
    }

    // A new value inside the innermost open container, null if the limits forbid it.
    JsonDocument::Node* Append(JsonKind kind) {
        std::vector<JsonDocument::Node>& nodes = document_.nodes_;
        if (nodes.size() >= limits::kJsonValues) {
            refusal = {
                "limit",
                "the body holds more than " + std::to_string(limits::kJsonValues) + " JSON values",
                ""};
            return nullptr;
        }
        const auto index = static_cast<std::uint32_t>(nodes.size());
        JsonDocument::Node& node = nodes.emplace_back();
        node.kind = kind;
        node.end = index + 1;
        if (!open_.empty()) {
            node.parent = open_.back();
            node.key_begin = key_begin_;
            node.key_size = key_size_;
            ++nodes[open_.back()].children;
        }
        key_size_ = 0;
        last_ = index;
        return &node;
    }

    bool Open(JsonKind kind) {
        if (!Append(kind)) return false;
        if (open_.size() >= static_cast<std::size_t>(limits::kJsonDepth)) {
            return Refuse("limit",
                          "values are nested deeper than " + std::to_string(limits::kJsonDepth));
        }
        open_.push_back(last_);
        return true;
    }

    bool Close() {
        document_.nodes_[open_.back()].end = static_cast<std::uint32_t>(document_.nodes_.size());
        last_ = open_.back();
        open_.pop_back();
        return true;
    }

    JsonDocument& document_;
    std::vector<std::uint32_t> open_;
    std::uint32_t last_ = 0;
    std::uint32_t key_begin_ = 0, key_size_ = 0;
};

Decoded<JsonDocument> JsonDocument::Parse(std::string_view text) {
    if (text.size() > limits::kBodyBytes) {
        return Refusal{"too_large",
                       "the body is larger than " + std::to_string(limits::kBodyBytes) + " bytes",
                       ""};
    }
    JsonDocument document;
    JsonBuilder builder(document);
    if (!nlohmann::json::sax_parse(text.begin(), text.end(), &builder)) return builder.refusal;
    return document;
}

JsonKind JsonView::kind() const {
    return document_->nodes_[index_].kind;
}
bool JsonView::boolean() const {
    return document_->nodes_[index_].boolean;
}
double JsonView::number() const {
    return document_->nodes_[index_].number;
}

std::string_view JsonView::string() const {
    const JsonDocument::Node& node = document_->nodes_[index_];
    return document_->Text(node.text_begin, node.text_size);
}

std::string_view JsonView::key() const {
    const JsonDocument::Node& node = document_->nodes_[index_];
    return document_->Text(node.key_begin, node.key_size);
}

std::size_t JsonView::child_count() const {
    return document_->nodes_[index_].children;
}

std::size_t JsonView::value_count() const {
    return document_->nodes_[index_].end - index_;
}

std::optional<JsonView> JsonView::FirstChild() const {
    if (child_count() == 0) return std::nullopt;
    return JsonView(document_, index_ + 1);
}

std::optional<JsonView> JsonView::NextSibling() const {
    const JsonDocument::Node& node = document_->nodes_[index_];
    if (index_ == 0 || node.end >= document_->nodes_[node.parent].end) return std::nullopt;
    return JsonView(document_, node.end);
}

std::optional<JsonView> JsonView::Find(std::string_view name) const {
    for (std::optional<JsonView> child = FirstChild(); child; child = child->NextSibling()) {
        if (child->key() == name) return child;
    }
    return std::nullopt;
}

std::string JsonView::Pointer() const {
    // Collect the way up to the whole, then write it down from the top.
    std::vector<std::uint32_t> way;
    for (std::uint32_t i = index_; i != 0; i = document_->nodes_[i].parent) way.push_back(i);
    std::string pointer;
    for (auto at = way.rbegin(); at != way.rend(); ++at) {
        const JsonDocument::Node& node = document_->nodes_[*at];
        if (document_->nodes_[node.parent].kind == JsonKind::kObject) {
            AppendPointerToken(pointer, document_->Text(node.key_begin, node.key_size));
            continue;
        }
        std::size_t position = 0;
        for (std::uint32_t i = node.parent + 1; i != *at; i = document_->nodes_[i].end) ++position;
        pointer += '/' + std::to_string(position);
    }
    return pointer;
}

JsonTree JsonView::Tree() const {
    JsonTree tree;
    tree.pointer = Pointer();
    switch (kind()) {
        case JsonKind::kNull:
            break;
        case JsonKind::kBoolean:
            tree.value = boolean();
            break;
        case JsonKind::kNumber:
            tree.value = number();
            break;
        case JsonKind::kString:
            tree.value = std::string(string());
            break;
        case JsonKind::kArray: {
            JsonTree::Array items;
            for (auto child = FirstChild(); child; child = child->NextSibling()) {
                items.push_back(child->Tree());
            }
            tree.value = std::move(items);
            break;
        }
        case JsonKind::kObject: {
            JsonTree::Object members;
            for (auto child = FirstChild(); child; child = child->NextSibling()) {
                members.emplace(std::string(child->key()), child->Tree());
            }
            tree.value = std::move(members);
            break;
        }
    }
    return tree;
}

}  // namespace flare::wire
