// SPDX-License-Identifier: Apache-2.0
//
// Two steps. The TOML parser's tree becomes a DocumentNode tree, each node with its place; then one
// function reads the meaning, whatever syntax the tree came from. The first error ends the reading.
// What numbers are *possible* (an index of 0.9, a negative gap) is not judged here but by
// FindFaults, which serves lenses from every source; here a number must only be one.
#include "core/optics/prescription_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <utility>

// toml++ 3.3 asserts (or, with NDEBUG and clang, assumes) what an outside text can break, as "[}]"
// does, and then handles the case properly a few lines on. So its assertions are turned off
// whatever NDEBUG says; the reader's tests and fuzzing under the sanitizers stand in for them.
#define TOML_EXCEPTIONS 0
#define TOML_ASSERT(expression) static_cast<void>(0)
#pragma push_macro("NDEBUG")
#undef NDEBUG
#include <toml++/toml.h>
#pragma pop_macro("NDEBUG")

namespace flare {

namespace {

constexpr std::size_t kMaxNameBytes = 100;

// ---- TOML text to tree ----

std::string PlaceText(const toml::source_position& place) {
    return "line " + std::to_string(place.line) + ", column " + std::to_string(place.column);
}

DocumentNode FromToml(const toml::node& node, const std::string& place_if_none) {
    DocumentNode out;
    const toml::source_position place = node.source().begin;
    out.where = place.line > 0 ? PlaceText(place) : place_if_none;
    if (const toml::table* table = node.as_table()) {
        DocumentNode::Table children;
        for (const auto& [key, child] : *table) {
            const toml::source_position key_place = key.source().begin;
            children.emplace(
                std::string(key.str()),
                FromToml(child, key_place.line > 0 ? PlaceText(key_place) : out.where));
        }
        out.value = std::move(children);
    } else if (const toml::array* array = node.as_array()) {
        DocumentNode::Array children;
        for (const toml::node& child : *array) children.push_back(FromToml(child, out.where));
        out.value = std::move(children);
    } else if (const auto* text = node.as_string()) {
        out.value = text->get();
    } else if (const auto* real = node.as_floating_point()) {
        out.value = real->get();
    } else if (const auto* integer = node.as_integer()) {
        out.value = static_cast<double>(integer->get());
    } else if (const auto* boolean = node.as_boolean()) {
        out.value = boolean->get();
    }  // else a date or a time: no key of a lens file takes one
    return out;
}

// ---- Tree to meaning ----

const char* TypeName(const DocumentNode& node) {
    static constexpr std::array<const char*, 6> kNames = {
        "null, a date or a time", "a boolean", "a number", "a string", "an array", "a table"};
    return kNames[node.value.index()];
}

// Reads the fields of one table into variables and keeps the first error.
class Fields {
  public:
    // `owner` names the table in messages: "the lens", "surface 3".
    Fields(const DocumentNode& node, std::string owner) : node_(node), owner_(std::move(owner)) {
        if (node.table() == nullptr) {
            Fail(owner_ + " must be a table, not " + TypeName(node), node.where);
        }
    }

    // Refuses every key that is neither known nor part of the format that a later version reads.
    void Allow(std::initializer_list<std::string_view> known,
               std::initializer_list<std::string_view> later) {
        if (error_.has_value()) return;
        const auto has = [](std::initializer_list<std::string_view> keys, std::string_view key) {
            return std::find(keys.begin(), keys.end(), key) != keys.end();
        };
        for (const auto& [key, child] : *node_.table()) {
            if (has(known, key)) continue;
            if (has(later, key)) {
                Fail("\"" + key + "\" of " + owner_ + " is not supported yet", child.where,
                     "unsupported");
            } else {
                Fail(owner_ + " has no key \"" + key + "\"", child.where);
            }
        }
    }

    const DocumentNode* Find(const std::string& key) const {
        if (error_.has_value()) return nullptr;
        const auto found = node_.table()->find(key);
        return found == node_.table()->end() ? nullptr : &found->second;
    }

    const DocumentNode* Require(const std::string& key) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) Fail(owner_ + " needs \"" + key + "\"", node_.where);
        return found;
    }

    bool Read(const std::string& key, std::string& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->string() == nullptr) return FailType(key, "a string", *found);
        out = *found->string();
        return true;
    }

    bool Read(const std::string& key, bool& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->boolean() == nullptr) return FailType(key, "true or false", *found);
        out = *found->boolean();
        return true;
    }

    bool Read(const std::string& key, double& out) {
        const DocumentNode* found = Find(key);
        if (found == nullptr) return false;
        if (found->number() == nullptr) return FailType(key, "a number", *found);
        if (!std::isfinite(*found->number())) {
            Fail("\"" + key + "\" of " + owner_ + " is not a finite number", found->where);
            return false;
        }
        out = *found->number();
        return true;
    }

    void Read(const std::string& key, std::optional<double>& out) {
        double value = 0.0;
        if (Read(key, value)) out = value;
    }

    void Fail(std::string message, std::string where, std::string code = "bad_lens") {
        if (!error_.has_value())
            error_ = Error{std::move(code), std::move(message), std::move(where)};
    }

    const std::optional<Error>& error() const { return error_; }

  private:
    bool FailType(const std::string& key, const char* wanted, const DocumentNode& found) {
        Fail("\"" + key + "\" of " + owner_ + " must be " + wanted + ", not " + TypeName(found),
             found.where);
        return false;
    }

    const DocumentNode& node_;
    std::string owner_;
    std::optional<Error> error_;
};

void ReadKind(Fields& fields, const std::string& owner, SurfaceKind& kind) {
    std::string word;
    if (!fields.Read("kind", word)) return;
    const std::string& where = fields.Find("kind")->where;
    if (word == "sphere") {
        kind = SurfaceKind::kSphere;
    } else if (word == "plane") {
        kind = SurfaceKind::kPlane;
    } else if (word == "stop") {
        kind = SurfaceKind::kStop;
    } else if (word == "asphere" || word == "cylinder_x" || word == "cylinder_y" ||
               word == "toroid" || word == "sensor") {
        fields.Fail("the kind \"" + word + "\" of " + owner + " is not supported yet", where,
                    "unsupported");
    } else {
        fields.Fail("\"kind\" of " + owner + " is \"" + word +
                        "\"; it must be \"sphere\", \"plane\" or \"stop\"",
                    where);
    }
}

Result<SurfacePrescription> ReadSurface(const DocumentNode& node, std::size_t index, bool last) {
    const std::string owner = SurfaceLabel(index);
    Fields fields(node, owner);
    fields.Allow({"kind", "radius_mm", "gap_mm", "nd", "vd", "semi_diameter_mm", "coating"},
                 {"conic", "asphere", "glass", "radius_x_mm", "radius_y_mm"});

    SurfacePrescription out;
    out.where = node.where;
    ReadKind(fields, owner, out.kind);
    fields.Read("radius_mm", out.radius_mm);
    out.gap_given = fields.Read("gap_mm", out.gap_mm);
    if (!last) fields.Require("gap_mm");
    fields.Read("nd", out.nd);
    fields.Read("vd", out.vd);
    fields.Require("semi_diameter_mm");
    fields.Read("semi_diameter_mm", out.semi_diameter_mm);
    if (std::string coating; fields.Read("coating", coating)) out.coating = coating;

    if (fields.error().has_value()) return *fields.error();
    return out;
}

void ReadName(Fields& fields, std::string& name) {
    fields.Require("name");
    if (!fields.Read("name", name)) return;
    const bool printable = std::all_of(name.begin(), name.end(), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte >= 0x20 && byte != 0x7f;
    });
    if (name.empty() || name.size() > kMaxNameBytes || !printable) {
        fields.Fail("\"name\" must have 1 to " + std::to_string(kMaxNameBytes) +
                        " bytes and no control characters",
                    fields.Find("name")->where);
    }
}

void ReadDesign(Fields& fields, Prescription& out) {
    const DocumentNode* node = fields.Find("design");
    if (node == nullptr) return;
    Fields design(*node, "design");
    design.Allow({"focal_mm", "f_number", "image_circle_mm"}, {});
    design.Read("focal_mm", out.design_focal_mm);
    design.Read("f_number", out.design_f_number);
    design.Read("image_circle_mm", out.design_image_circle_mm);
    for (const auto& [key, value] :
         {std::pair("focal_mm", out.design_focal_mm), std::pair("f_number", out.design_f_number),
          std::pair("image_circle_mm", out.design_image_circle_mm)}) {
        if (value.has_value() && !(*value > 0.0)) {
            design.Fail(
                std::string("\"") + key + "\" of design must be above 0, not " + NumberText(*value),
                design.Find(key)->where);
        }
    }
    if (design.error().has_value()) {
        fields.Fail(design.error()->message, design.error()->where, design.error()->code);
    }
}

void ReadSurfaces(Fields& fields, Prescription& out) {
    const DocumentNode* node = fields.Require("surface");
    if (node == nullptr) return;
    const DocumentNode::Array* rows = node->array();
    if (rows == nullptr) {
        fields.Fail(std::string("\"surface\" must be an array of tables, not ") + TypeName(*node),
                    node->where);
        return;
    }
    if (rows->empty() || rows->size() > static_cast<std::size_t>(kMaxSurfaces)) {
        fields.Fail("a lens has 1 to " + std::to_string(kMaxSurfaces) + " surfaces, not " +
                        std::to_string(rows->size()),
                    node->where);
        return;
    }
    for (std::size_t i = 0; i < rows->size(); ++i) {
        Result<SurfacePrescription> surface = ReadSurface((*rows)[i], i, i + 1 == rows->size());
        if (!surface) {
            fields.Fail(surface.error().message, surface.error().where, surface.error().code);
            return;
        }
        out.surfaces.push_back(std::move(*surface));
    }
}

}  // namespace

Result<Prescription> ReadPrescription(const DocumentNode& root) {
    Fields fields(root, "the lens");
    fields.Allow({"name", "maker", "patent", "source", "notes", "design", "default_coating",
                  "fisheye", "surface"},
                 {"states"});
    Prescription out;
    ReadName(fields, out.name);
    fields.Read("maker", out.maker);
    fields.Read("patent", out.patent);
    fields.Read("source", out.source);
    fields.Read("notes", out.notes);
    fields.Read("default_coating", out.default_coating);
    fields.Read("fisheye", out.fisheye);
    ReadDesign(fields, out);
    ReadSurfaces(fields, out);
    if (fields.error().has_value()) return *fields.error();
    return out;
}

Result<Prescription> ReadPrescriptionToml(std::string_view text) {
    if (text.size() > kMaxLensFileBytes) {
        return Error{"bad_lens",
                     "a lens file may have " + std::to_string(kMaxLensFileBytes) + " bytes, not " +
                         std::to_string(text.size()),
                     ""};
    }
    const toml::parse_result parsed = toml::parse(text);
    if (!parsed) {
        return Error{"bad_lens", "not TOML: " + std::string(parsed.error().description()),
                     PlaceText(parsed.error().source().begin)};
    }
    return ReadPrescription(FromToml(parsed.table(), "line 1, column 1"));
}

}  // namespace flare
