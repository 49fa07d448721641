// SPDX-License-Identifier: Apache-2.0
//
// The meaning of a document tree, whatever syntax it came from. The first error ends the reading.
// What numbers are *possible* (an index of 0.9, a negative gap) is not judged here but by
// FindFaults, which serves lenses from every source; here a number must only be one.
#include "core/prescription/prescription_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/prescription/coating_reader.h"
#include "core/prescription/document_fields.h"
#include "core/prescription/states_reader.h"
#include "core/prescription/toml_document.h"

namespace flare {

namespace {

constexpr std::size_t kMaxNameBytes = 100;

void ReadKind(Fields& fields, const std::string& owner, SurfaceKind& kind) {
    static constexpr std::array kKinds = {SurfaceKind::kSphere,    SurfaceKind::kPlane,
                                          SurfaceKind::kAsphere,   SurfaceKind::kCylinderX,
                                          SurfaceKind::kCylinderY, SurfaceKind::kToroid,
                                          SurfaceKind::kStop,      SurfaceKind::kSensor};
    std::string word;
    if (!fields.Read("kind", word)) return;
    std::string known;
    for (const SurfaceKind candidate : kKinds) {
        if (word == KindName(candidate)) {
            kind = candidate;
            return;
        }
        known += (known.empty() ? "\"" : ", \"") + std::string(KindName(candidate)) + "\"";
    }
    fields.Fail("\"kind\" of " + owner + " is \"" + word + "\"; it must be one of " + known,
                fields.Find("kind")->where);
}

Result<SurfacePrescription> ReadSurface(const DocumentNode& node, std::size_t index, bool last) {
    const std::string owner = SurfaceLabel(index);
    Fields fields(node, owner);
    fields.Allow({"kind", "radius_mm", "radius_x_mm", "radius_y_mm", "conic", "asphere", "gap_mm",
                  "glass", "nd", "vd", "semi_diameter_mm", "coating", "reflectance"},
                 {});

    SurfacePrescription out;
    out.where = node.where;
    ReadKind(fields, owner, out.kind);
    fields.Read("radius_mm", out.radius_mm);
    fields.Read("radius_x_mm", out.radius_x_mm);
    fields.Read("radius_y_mm", out.radius_y_mm);
    fields.Read("conic", out.conic);
    fields.Read("asphere", out.asphere);
    out.gap_given = fields.Read("gap_mm", out.gap_mm);
    if (!last) fields.Require("gap_mm");
    if (std::string glass; fields.Read("glass", glass)) out.glass = glass;
    fields.Read("nd", out.nd);
    fields.Read("vd", out.vd);
    fields.Require("semi_diameter_mm");
    fields.Read("semi_diameter_mm", out.semi_diameter_mm);
    if (std::string coating; fields.Read("coating", coating)) out.coating = coating;
    if (out.kind == SurfaceKind::kSensor) fields.Require("reflectance");
    fields.Read("reflectance", out.reflectance);

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
    design.Allow({"focal_mm", "f_number", "image_circle_mm", "focal_tolerance",
                  "f_number_tolerance", "section"},
                 {});
    design.Read("focal_mm", out.design_focal_mm);
    design.Read("f_number", out.design_f_number);
    design.Read("image_circle_mm", out.design_image_circle_mm);
    design.Read("focal_tolerance", out.focal_tolerance);
    design.Read("f_number_tolerance", out.f_number_tolerance);
    for (const auto& [key, value] :
         {std::pair("focal_mm", out.design_focal_mm), std::pair("f_number", out.design_f_number),
          std::pair("image_circle_mm", out.design_image_circle_mm),
          std::pair("focal_tolerance", out.focal_tolerance),
          std::pair("f_number_tolerance", out.f_number_tolerance)}) {
        if (value.has_value() && !(*value > 0.0)) {
            design.Fail(
                std::string("\"") + key + "\" of design must be above 0, not " + NumberText(*value),
                design.Find(key)->where);
        }
    }
    if (std::string section; design.Read("section", section)) {
        if (section != "x" && section != "y") {
            design.Fail("\"section\" of design is \"" + section + "\"; it must be \"x\" or \"y\"",
                        design.Find("section")->where);
        }
        out.design_section = section == "x" ? Section::kX : Section::kY;
    }
    if (design.error().has_value()) {
        fields.Fail(design.error()->message, design.error()->where, design.error()->code);
    }
}

bool SaysSensor(const DocumentNode& surface) {
    if (surface.table() == nullptr) return false;
    const auto kind = surface.table()->find("kind");
    return kind != surface.table()->end() && kind->second.string() != nullptr &&
           *kind->second.string() == KindName(SurfaceKind::kSensor);
}

void ReadYear(Fields& fields, std::optional<int>& year) {
    double value = 0.0;
    if (!fields.Read("year", value)) return;
    if (value != std::floor(value) || value < 1800.0 || value > 2200.0) {
        fields.Fail("\"year\" must be a year, not " + NumberText(value),
                    fields.Find("year")->where);
        return;
    }
    year = static_cast<int>(value);
}

void ReadCoatings(Fields& fields, CoatingDefinitions& out) {
    const DocumentNode* node = fields.Find("coatings");
    if (node == nullptr) return;
    Result<CoatingDefinitions> coatings = ReadCoatingDefinitions(*node);
    if (coatings.ok()) {
        out = std::move(*coatings);
    } else {
        fields.Fail(coatings.error().message, coatings.error().where, coatings.error().code);
    }
}

void ReadSurfaces(Fields& fields, Prescription& out) {
    const DocumentNode* node = fields.Require("surface");
    if (node == nullptr) return;
    const DocumentNode::Array* rows = node->array();
    if (rows == nullptr) {
        fields.Fail(std::string("\"surface\" must be an array of tables, not ") + TypeNameOf(*node),
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
        // The last surface that light passes may leave the gap to the sensor out.
        const bool last =
            i + 1 == rows->size() || (i + 2 == rows->size() && SaysSensor(rows->back()));
        Result<SurfacePrescription> surface = ReadSurface((*rows)[i], i, last);
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
                  "coatings", "fisheye", "year", "surface", "states"},
                 {});
    Prescription out;
    ReadName(fields, out.name);
    fields.Read("maker", out.maker);
    fields.Read("patent", out.patent);
    fields.Read("source", out.source);
    fields.Read("notes", out.notes);
    fields.Read("default_coating", out.default_coating);
    ReadCoatings(fields, out.coatings);
    fields.Read("fisheye", out.fisheye);
    ReadYear(fields, out.year);
    ReadDesign(fields, out);
    ReadSurfaces(fields, out);
    if (const DocumentNode* states = fields.Find("states")) {
        Result<StateTable> table = ReadStates(*states);
        if (!table) return table.error();
        out.states = std::move(*table);
    }
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
    const Result<DocumentNode> root = ParseToml(text, "bad_lens");
    if (!root) return root.error();
    return ReadPrescription(*root);
}

}  // namespace flare
