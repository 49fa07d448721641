// SPDX-License-Identifier: Apache-2.0
//
// Realflare's lens models: JSON with lens_elements of radius, distance, refractive_index, abbe_nr
// and height (semi-diameter), and aperture_index, the row of the stop.
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/json_members.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

Result<SurfacePrescription> ElementOf(const DocumentNode& row, bool stop) {
    SurfacePrescription out;
    out.where = row.where;
    out.gap_given = true;
    double numbers[5] = {};
    static constexpr const char* kKeys[5] = {"radius", "distance", "refractive_index", "abbe_nr",
                                             "height"};
    for (std::size_t i = 0; i < 5; ++i) {
        const Result<double> value = NumberMember(row, kKeys[i]);
        if (!value) return value.error();
        numbers[i] = *value;
    }
    out.gap_mm = numbers[1];
    out.semi_diameter_mm = numbers[4];
    if (stop) {
        out.kind = SurfaceKind::kStop;
    } else {
        out.radius_mm = numbers[0];
    }
    SetMedium(out, numbers[2], numbers[3]);
    return out;
}

}  // namespace

Result<LensDraft> ReadRealflare(const DocumentNode& root) {
    LensDraft draft;
    const Result<const DocumentNode::Array*> rows = SurfaceArray(root, "lens_elements");
    if (!rows) return rows.error();
    const Result<double> stop = NumberMember(root, "aperture_index");
    if (!stop) return stop.error();
    if (*stop < 0.0 || *stop >= static_cast<double>((*rows)->size())) {
        return Error{"bad_lens", "aperture_index is " + NumberText(*stop) + ", which is no row",
                     Member(root, "aperture_index")->where};
    }
    const auto stop_row = static_cast<std::size_t>(*stop);
    for (std::size_t i = 0; i < (*rows)->size(); ++i) {
        const DocumentNode& row = (**rows)[i];
        const bool flat = OptionalNumber(row, "radius") == 0.0;
        Result<SurfacePrescription> surface = ElementOf(row, i == stop_row && flat);
        if (!surface) return surface.error();
        draft.lens.surfaces.push_back(std::move(*surface));
        if (i == stop_row && !flat) draft.stop_on = i;
    }
    SurfacePrescription& last = draft.lens.surfaces.back();
    last.gap_given = last.gap_mm != 0.0;
    draft.title = TextMember(root, "name");
    draft.lens.patent = TextMember(root, "patent_number");
    draft.lens.notes = TextMember(root, "notes");
    if (const std::optional<double> year = OptionalNumber(root, "year");
        year && *year >= 1800.0 && *year <= 2200.0) {
        draft.lens.year = static_cast<int>(*year);
    }
    if (const auto focal = OptionalNumber(root, "focal_length"); focal && *focal > 0.0) {
        draft.lens.design_focal_mm = *focal;
    }
    if (const auto f_number = OptionalNumber(root, "fstop"); f_number && *f_number > 0.0) {
        draft.lens.design_f_number = draft.f_number = *f_number;
    }
    draft.Remark("The file has no coatings: every surface is bare.");
    return draft;
}

}  // namespace flare
