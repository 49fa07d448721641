// SPDX-License-Identifier: Apache-2.0
//
// Optiland's JSON: surface_group.surfaces from the object to the image, each with its vertex in
// geometry.cs, a radius and a conic, and the material behind it.
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/glass_names.h"
#include "core/lens_import/json_members.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

bool MemberIsTrue(const DocumentNode& node, const std::string& key) {
    const DocumentNode* member = Member(node, key);
    return member != nullptr && member->boolean() != nullptr && *member->boolean();
}

bool IsNull(const DocumentNode* node) {
    return node == nullptr || std::holds_alternative<std::monostate>(node->value);
}

// The folder that a data file stands in is the maker: .../glass/hikari/SK16.yml.
std::vector<std::string> MakersOf(const DocumentNode& material) {
    std::vector<std::string> makers;
    const std::string path = TextMember(material, "filename");
    const std::size_t end = path.find_last_of("/\\");
    if (end != std::string::npos && end > 0) {
        const std::size_t begin = path.find_last_of("/\\", end - 1);
        makers.push_back(
            UpperCase(path.substr(begin == std::string::npos ? 0 : begin + 1,
                                  end - (begin == std::string::npos ? 0 : begin + 1))));
    }
    if (const std::string reference = TextMember(material, "reference"); !reference.empty()) {
        makers.push_back(UpperCase(reference));
    }
    return makers;
}

std::optional<Error> SetMaterial(const DocumentNode& material, SurfacePrescription& surface) {
    const std::string type = TextMember(material, "type");
    if (type == "IdealMaterial") {
        const Result<double> index = NumberMember(material, "index");
        if (!index) return index.error();
        SetMedium(surface, *index, std::nullopt);
        return std::nullopt;
    }
    if (type == "AbbeMaterial") {
        const Result<double> index = NumberMember(material, "index");
        if (!index) return index.error();
        SetMedium(surface, *index, OptionalNumber(material, "abbe"));
        return std::nullopt;
    }
    if (type == "Mirror") {
        return Error{"unsupported", "a mirror: lenses with mirrors cannot be traced",
                     material.where};
    }
    const Result<std::string> name =
        CatalogueName(TextMember(material, "name"), MakersOf(material));
    if (!name) return Error{"bad_lens", name.error().message, material.where};
    surface.glass = *name;
    return std::nullopt;
}

std::optional<Error> SetGeometry(const DocumentNode& geometry, SurfacePrescription& surface) {
    const std::string type = TextMember(geometry, "type");
    if (type != "Plane" && type != "StandardGeometry" && type != "EvenAsphere") {
        return Error{"unsupported", "the geometry " + Quoted(type) + " cannot be read",
                     geometry.where};
    }
    // A plane's radius is infinite, which JSON has no number for.
    surface.radius_mm = type == "Plane" ? 0.0 : OptionalNumber(geometry, "radius").value_or(0.0);
    surface.conic = type == "Plane" ? 0.0 : OptionalNumber(geometry, "conic").value_or(0.0);
    if (const DocumentNode* terms = Member(geometry, "coefficients");
        type == "EvenAsphere" && terms != nullptr && terms->array() != nullptr) {
        // c_0 r^2 + c_1 r^4 + ...
        for (std::size_t i = 0; i < terms->array()->size(); ++i) {
            const double* value = (*terms->array())[i].number();
            if (value == nullptr) {
                return Error{"bad_lens", "a coefficient is no number", terms->where};
            }
            if (i == 0 && *value != 0.0) {
                return Error{"unsupported", "the term of r^2 cannot be read", terms->where};
            }
            if (i > 0) surface.asphere.push_back(*value);
        }
    }
    while (!surface.asphere.empty() && surface.asphere.back() == 0.0) surface.asphere.pop_back();
    if (!surface.asphere.empty() || (surface.conic != 0.0 && surface.radius_mm != 0.0)) {
        surface.kind = SurfaceKind::kAsphere;
    } else {
        surface.conic = 0.0;
    }
    return std::nullopt;
}

Result<double> VertexOf(const DocumentNode& geometry) {
    const DocumentNode* cs = Member(geometry, "cs");
    if (cs == nullptr) return Error{"bad_lens", "there is no \"cs\" here", geometry.where};
    for (const char* key : {"x", "y", "rx", "ry", "rz"}) {
        if (OptionalNumber(*cs, key).value_or(0.0) != 0.0) {
            return Error{"unsupported", "tilted and decentred surfaces cannot be read", cs->where};
        }
    }
    return NumberMember(*cs, "z");
}

class OptilandReader {
  public:
    Result<LensDraft> Read(const DocumentNode& root) {
        const DocumentNode* group = Member(root, "surface_group");
        if (group == nullptr) return Error{"bad_lens", "there is no \"surface_group\"", root.where};
        const Result<const DocumentNode::Array*> rows = SurfaceArray(*group, "surfaces");
        if (!rows) return rows.error();
        if ((*rows)->size() < 3) {
            return Error{"bad_lens", "there are no surfaces between object and image",
                         group->where};
        }
        for (std::size_t i = 1; i < (*rows)->size(); ++i) {
            if (const auto error = Add((**rows)[i], i + 1 == (*rows)->size())) return *error;
        }
        ReadBeam(root);
        DropDummies(draft_);
        if (!unread_.empty()) {
            draft_.Remark("Not read: the aperture, coating or bsdf of " + SurfaceList(unread_) +
                          " of the file.");
        }
        RemarkBare(draft_);
        return std::move(draft_);
    }

  private:
    std::optional<Error> Add(const DocumentNode& row, bool image) {
        const DocumentNode* geometry = Member(row, "geometry");
        if (geometry == nullptr)
            return Error{"bad_lens", "this surface has no geometry", row.where};
        const Result<double> z = VertexOf(*geometry);
        if (!z) return z.error();
        std::vector<SurfacePrescription>& surfaces = draft_.lens.surfaces;
        if (!surfaces.empty()) {
            surfaces.back().gap_mm = *z - last_z_;
            surfaces.back().gap_given = true;
        }
        last_z_ = *z;
        if (image) return std::nullopt;
        SurfacePrescription surface;
        surface.where = row.where;
        if (const auto error = SetGeometry(*geometry, surface)) return error;
        if (MemberIsTrue(row, "is_reflective")) {
            return Error{"unsupported", "a mirror: lenses with mirrors cannot be traced",
                         row.where};
        }
        const DocumentNode* material = Member(row, "material_post");
        if (material == nullptr) {
            return Error{"bad_lens", "there is no \"material_post\" here", row.where};
        }
        if (const auto error = SetMaterial(*material, surface)) return error;
        const DocumentNode* aperture = Member(row, "aperture");
        if (!IsNull(aperture)) {
            surface.semi_diameter_mm = OptionalNumber(*aperture, "r_max").value_or(0.0);
        }
        if ((!IsNull(aperture) && surface.semi_diameter_mm == 0.0) ||
            !IsNull(Member(row, "coating")) || !IsNull(Member(row, "bsdf"))) {
            unread_.push_back(surfaces.size() + 1);
        }
        if (MemberIsTrue(row, "is_stop")) draft_.stop_on = surfaces.size();
        surfaces.push_back(std::move(surface));
        return std::nullopt;
    }

    void ReadBeam(const DocumentNode& root) {
        if (const DocumentNode* aperture = Member(root, "aperture")) {
            const std::string type = TextMember(*aperture, "type");
            const std::optional<double> value = OptionalNumber(*aperture, "value");
            if (type == "EPD") {
                draft_.pupil_mm = value;
            } else if (type == "imageFNO") {
                draft_.f_number = value;
                if (value && *value > 0.0) draft_.lens.design_f_number = value;
            } else {
                draft_.Remark("The aperture of type " + Quoted(type) + " is not read.");
            }
        }
        const DocumentNode* group = Member(root, "fields");
        const DocumentNode* fields = group == nullptr ? nullptr : Member(*group, "fields");
        if (fields == nullptr || fields->array() == nullptr) return;
        double largest = 0.0;
        bool angle = true;
        for (const DocumentNode& field : *fields->array()) {
            largest = std::max(largest, std::hypot(OptionalNumber(field, "x").value_or(0.0),
                                                   OptionalNumber(field, "y").value_or(0.0)));
            const std::string type = TextMember(field, "field_type");
            angle = angle && (type.empty() || type == "angle");
        }
        if (angle && largest > 0.0) draft_.field_deg = largest;
    }

    LensDraft draft_;
    std::vector<std::size_t> unread_;
    double last_z_ = 0.0;
};

}  // namespace

Result<LensDraft> ReadOptiland(const DocumentNode& root) {
    return OptilandReader().Read(root);
}

}  // namespace flare
