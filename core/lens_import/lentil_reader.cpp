// SPDX-License-Identifier: Apache-2.0
//
// One lens of lentil's database: JSON with optical-elements-patent, each of radius, thickness, ior,
// abbe, material, housing-radius (semi-diameter) and lens-geometry. Planes have radii of four nines
// and more. Its cylinders are "cyl-x" and "cyl-y"; in which section they bend is not written down
// anywhere, so the letter is taken at its word and a remark asks to check.
#include <cmath>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/json_members.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

// 9999, 99999, 999999.0, 1e6: how the database writes a plane.
bool MeansPlane(double radius) {
    const double size = std::abs(radius);
    return size == 9999.0 || size == 99999.0 || size == 999999.0 || size >= 1e6;
}

Result<SurfacePrescription> ElementOf(const DocumentNode& row, bool& cylinder) {
    SurfacePrescription out;
    out.where = row.where;
    out.gap_given = true;
    double numbers[3] = {};
    static constexpr const char* kKeys[3] = {"radius", "thickness", "housing-radius"};
    for (std::size_t i = 0; i < 3; ++i) {
        const Result<double> value = NumberMember(row, kKeys[i]);
        if (!value) return value.error();
        numbers[i] = *value;
    }
    out.gap_mm = numbers[1];
    out.semi_diameter_mm = numbers[2];
    if (const DocumentNode* asphere = Member(row, "aspherical-equation");
        asphere != nullptr && !std::holds_alternative<std::monostate>(asphere->value)) {
        return Error{"unsupported", "an aspherical-equation cannot be read", asphere->where};
    }
    const std::string material = TextMember(row, "material");
    if (material == "iris") {
        out.kind = SurfaceKind::kStop;
        return out;
    }
    const std::string geometry = TextMember(row, "lens-geometry");
    cylinder = geometry == "cyl-x" || geometry == "cyl-y";
    if (!cylinder && geometry != "spherical" && geometry != "planar") {
        return Error{"unsupported", "the lens-geometry " + Quoted(geometry) + " cannot be read",
                     row.where};
    }
    if (!MeansPlane(numbers[0]) && geometry != "planar") {
        out.radius_mm = numbers[0];
        if (cylinder) {
            out.kind = geometry == "cyl-x" ? SurfaceKind::kCylinderX : SurfaceKind::kCylinderY;
        }
    }
    if (material == "air") return out;
    const Result<double> nd = NumberMember(row, "ior");
    if (!nd) return nd.error();
    SetMedium(out, *nd, OptionalNumber(row, "abbe"));
    return out;
}

}  // namespace

Result<LensDraft> ReadLentil(const DocumentNode& root) {
    LensDraft draft;
    const Result<const DocumentNode::Array*> rows = SurfaceArray(root, "optical-elements-patent");
    if (!rows) return rows.error();
    bool cylinders = false;
    for (const DocumentNode& row : **rows) {
        bool cylinder = false;
        Result<SurfacePrescription> surface = ElementOf(row, cylinder);
        if (!surface) return surface.error();
        cylinders = cylinders || cylinder;
        if (surface->kind == SurfaceKind::kStop) {
            StandInMediumInFront(*surface, draft.lens.surfaces);
        }
        draft.lens.surfaces.push_back(std::move(*surface));
    }
    SurfacePrescription& last = draft.lens.surfaces.back();
    last.gap_given = last.gap_mm != 0.0;
    draft.title = TextMember(root, "company") + " " + TextMember(root, "product-name");
    draft.lens.maker = TextMember(root, "company");
    draft.lens.patent = TextMember(root, "patent-number");
    draft.lens.notes = TextMember(root, "notes");
    if (const std::optional<double> year = OptionalNumber(root, "year");
        year && *year >= 1800.0 && *year <= 2200.0) {
        draft.lens.year = static_cast<int>(*year);
    }
    if (const auto focal = OptionalNumber(root, "focal-length-mm-patent"); focal && *focal > 0.0) {
        draft.lens.design_focal_mm = *focal;
    }
    if (const DocumentNode* stop = Member(root, "fstop"); stop != nullptr) {
        if (const auto f_number = OptionalNumber(*stop, "unscaled"); f_number && *f_number > 0.0) {
            draft.lens.design_f_number = *f_number;
        }
    }
    if (cylinders) {
        draft.Remark(
            "Cylinders \"cyl-x\" and \"cyl-y\" were read as curved in x and in y; the "
            "format does not say which it means. Compare the two focal lengths.");
    }
    if (const std::string doubt = TextMember(root, "notes-to-self"); !doubt.empty()) {
        draft.Remark("The file's own doubts: " + doubt);
    }
    if (Member(root, "optical-elements-adjusted") != nullptr) {
        draft.Remark("The file's adjusted elements are not read, only those of the patent.");
    }
    draft.Remark("The file has no coatings: every surface is bare.");
    return draft;
}

}  // namespace flare
