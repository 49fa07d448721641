// SPDX-License-Identifier: Apache-2.0
//
// Ray-optics' .roa: JSON of its objects, each with "__instance_type__" (module and class) and
// "attributes". The sequence is seq_model.ifcs with seq_model.gaps between them; the shape of an
// interface stands in profile_dict, or in older files in the interface itself. Its rims are those
// that the program worked out, unless an interface lists clear apertures.
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

// An object of the program: its class and its attributes.
struct Object {
    std::string module, type;
    const DocumentNode* attributes = nullptr;
};

Object ObjectIn(const DocumentNode* node) {
    Object out;
    if (node == nullptr) return out;
    if (const DocumentNode* names = Member(*node, "__instance_type__");
        names != nullptr && names->array() != nullptr && names->array()->size() == 2) {
        const auto& pair = *names->array();
        if (pair[0].string() != nullptr) out.module = *pair[0].string();
        if (pair[1].string() != nullptr) out.type = *pair[1].string();
    }
    out.attributes = Member(*node, "attributes");
    return out;
}

// The attributes of the object named `key` inside `node`.
const DocumentNode* AttributesOf(const DocumentNode* node, const char* key) {
    return node == nullptr ? nullptr : ObjectIn(Member(*node, key)).attributes;
}

bool HasText(const DocumentNode& node, const std::string& key, const char* text) {
    return TextMember(node, key) == text;
}

std::optional<Error> ReadMedium(const DocumentNode& gap, SurfacePrescription& surface) {
    const DocumentNode* node = Member(gap, "medium");
    const Object medium = ObjectIn(node);
    if (medium.type == "Air") return std::nullopt;
    if (medium.attributes == nullptr) {
        return Error{"bad_lens", "this gap has no medium", gap.where};
    }
    if (const std::string name = TextMember(*medium.attributes, "gname"); !name.empty()) {
        // opticalglass.schott: the maker is the module.
        std::vector<std::string> makers = {
            UpperCase(medium.module.substr(medium.module.rfind('.') + 1))};
        const Result<std::string> found = CatalogueName(name, makers);
        if (!found) return Error{"bad_lens", found.error().message, node->where};
        surface.glass = *found;
        return std::nullopt;
    }
    std::optional<double> nd = OptionalNumber(*medium.attributes, "nd");
    if (!nd) nd = OptionalNumber(*medium.attributes, "n");
    std::optional<double> vd = OptionalNumber(*medium.attributes, "vd");
    if (!vd) vd = OptionalNumber(*medium.attributes, "v");
    if (!nd) {
        return Error{"unsupported", "the medium " + Quoted(medium.type) + " cannot be read",
                     node->where};
    }
    SetMedium(surface, *nd, vd);
    return std::nullopt;
}

std::optional<Error> SetProfile(const Object& profile, const std::string& where,
                                SurfacePrescription& surface) {
    if (profile.attributes == nullptr) return Error{"bad_lens", "there is no profile here", where};
    const Result<double> curvature = NumberMember(*profile.attributes, "cv");
    if (!curvature) return curvature.error();
    surface.radius_mm = *curvature == 0.0 ? 0.0 : 1.0 / *curvature;
    if (!std::isfinite(surface.radius_mm)) surface.radius_mm = 0.0;
    if (profile.type == "Spherical") return std::nullopt;
    if (profile.type != "Conic" && profile.type != "EvenPolynomial") {
        return Error{"unsupported", "the profile " + Quoted(profile.type) + " cannot be read",
                     where};
    }
    surface.kind = SurfaceKind::kAsphere;
    surface.conic = OptionalNumber(*profile.attributes, "cc").value_or(0.0);
    const DocumentNode* terms = Member(*profile.attributes, "coefs");
    if (profile.type == "Conic" || terms == nullptr || terms->array() == nullptr) {
        return std::nullopt;
    }
    // Of r^2, r^4, ...
    for (std::size_t i = 0; i < terms->array()->size(); ++i) {
        const double* value = (*terms->array())[i].number();
        if (value == nullptr) return Error{"bad_lens", "a coefficient is no number", terms->where};
        if (i == 0 && *value != 0.0) {
            return Error{"unsupported", "the term of r^2 cannot be read", terms->where};
        }
        if (i > 0) surface.asphere.push_back(*value);
    }
    while (!surface.asphere.empty() && surface.asphere.back() == 0.0) surface.asphere.pop_back();
    return std::nullopt;
}

class RayOpticsReader {
  public:
    Result<LensDraft> Read(const DocumentNode& root) {
        const DocumentNode* model = AttributesOf(&root, "optical_model");
        const DocumentNode* sequence = AttributesOf(model, "seq_model");
        if (sequence == nullptr) {
            return Error{"bad_lens", "there is no optical_model with a seq_model", root.where};
        }
        profiles_ = Member(*model, "profile_dict");
        const Result<const DocumentNode::Array*> interfaces = SurfaceArray(*sequence, "ifcs");
        if (!interfaces) return interfaces.error();
        const Result<const DocumentNode::Array*> gaps = SurfaceArray(*sequence, "gaps");
        if (!gaps) return gaps.error();
        const std::size_t count = (*interfaces)->size();
        if (count < 3 || (*gaps)->size() + 1 != count) {
            return Error{"bad_lens",
                         "there must be one gap between every two interfaces, and one of these "
                         "between object and image",
                         sequence->where};
        }
        for (std::size_t i = 1; i + 1 < count; ++i) {
            if (const auto error = Add((**interfaces)[i], (**gaps)[i])) return *error;
        }
        const std::optional<double> stop = OptionalNumber(*sequence, "stop_surface");
        if (stop && *stop >= 1.0 && *stop < static_cast<double>(count) - 1.0) {
            draft_.stop_on = static_cast<std::size_t>(*stop) - 1;
        }
        ReadSpecifications(*model);
        DropDummies(draft_);
        draft_.Remark("The file has no coatings: every surface is bare.");
        return std::move(draft_);
    }

  private:
    std::optional<Error> Add(const DocumentNode& node, const DocumentNode& gap_node) {
        const Object face = ObjectIn(&node);
        const Object gap = ObjectIn(&gap_node);
        if (face.attributes == nullptr || gap.attributes == nullptr) {
            return Error{"bad_lens", "an interface or gap has no attributes", node.where};
        }
        SurfacePrescription surface;
        surface.where = node.where;
        surface.gap_given = true;
        if (face.type != "Surface") {
            return Error{"unsupported",
                         "an interface of the class " + Quoted(face.type) +
                             " cannot be traced: it has no glass and no shape",
                         node.where};
        }
        if (HasText(*face.attributes, "interact_mode", "reflect")) {
            return Error{"unsupported", "a mirror: lenses with mirrors cannot be traced",
                         node.where};
        }
        if (const DocumentNode* decenter = Member(*face.attributes, "decenter");
            decenter != nullptr && decenter->table() != nullptr) {
            return Error{"unsupported", "tilted and decentred surfaces cannot be read", node.where};
        }
        if (const auto error = SetProfile(ProfileOf(*face.attributes), node.where, surface)) {
            return error;
        }
        const Result<double> thickness = NumberMember(*gap.attributes, "thi");
        if (!thickness) return thickness.error();
        surface.gap_mm = *thickness;
        if (const auto error = ReadMedium(*gap.attributes, surface)) return error;
        surface.semi_diameter_mm = RimOf(*face.attributes);
        draft_.lens.surfaces.push_back(std::move(surface));
        return std::nullopt;
    }

    Object ProfileOf(const DocumentNode& face) const {
        if (const DocumentNode* inside = Member(face, "profile")) return ObjectIn(inside);
        if (profiles_ == nullptr) return {};
        return ObjectIn(Member(*profiles_, TextMember(face, "profile_id")));
    }

    static double RimOf(const DocumentNode& face) {
        if (const DocumentNode* clear = Member(face, "clear_apertures");
            clear != nullptr && clear->array() != nullptr && !clear->array()->empty()) {
            const DocumentNode* circle = ObjectIn(&clear->array()->front()).attributes;
            if (circle != nullptr && OptionalNumber(*circle, "radius")) {
                return *OptionalNumber(*circle, "radius");
            }
        }
        return OptionalNumber(face, "max_aperture").value_or(0.0);
    }

    void ReadSpecifications(const DocumentNode& model) {
        if (const DocumentNode* system = AttributesOf(&model, "system_spec")) {
            draft_.title = TextMember(*system, "title");
            const std::string unit = TextMember(*system, "_dimensions");
            const double factor = unit == "cm"                       ? 10.0
                                  : unit == "in" || unit == "inches" ? 25.4
                                  : unit == "m" || unit == "meters"  ? 1000.0
                                                                     : 1.0;
            ScaleLengths(draft_, factor);
        }
        const DocumentNode* optical = AttributesOf(&model, "optical_spec");
        const DocumentNode* pupil = AttributesOf(optical, "pupil");
        if (pupil == nullptr) return;
        const DocumentNode* key = Member(*pupil, "_key");
        const std::optional<double> value = OptionalNumber(*pupil, "value");
        if (key == nullptr || key->array() == nullptr || key->array()->empty()) return;
        const std::string* what = key->array()->back().string();
        if (what != nullptr && *what == "f/#" && value && *value > 0.0) {
            draft_.lens.design_f_number = value;
        } else if (what != nullptr && *what == "epd") {
            draft_.pupil_mm = value;
        }
    }

    LensDraft draft_;
    const DocumentNode* profiles_ = nullptr;
};

}  // namespace

Result<LensDraft> ReadRayOptics(const DocumentNode& root) {
    return RayOpticsReader().Read(root);
}

}  // namespace flare
