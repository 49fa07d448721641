// SPDX-License-Identifier: Apache-2.0
//
// FlareSim's .lens: "name:" and "focal_length:", and behind "surfaces:" rows of radius or "stop",
// gap, n_d, V_d, semi_ap and a coating code. In one large library of such files the column semi_ap
// holds diameters: the f-number, which stands in a comment, tells them apart.
#include <cmath>
#include <utility>

#include "core/lens_import/format_readers.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

Result<SurfacePrescription> RowOf(const TextLine& line, std::size_t& coated) {
    const std::vector<std::string_view> words = WordsOf(line.text);
    if (words.size() < 5 || words.size() > 6) {
        return Error{"bad_lens",
                     "a row has radius, gap, index, V-number, semi_ap and coating, but this one " +
                         std::to_string(words.size()) + " columns",
                     LinePlace(line.number)};
    }
    SurfacePrescription out;
    out.where = LinePlace(line.number);
    out.gap_given = true;
    if (LowerCase(words[0]) == "stop") {
        out.kind = SurfaceKind::kStop;
    } else {
        const Result<double> radius = RequireNumber(words[0], "the radius", line.number);
        if (!radius) return radius.error();
        out.radius_mm = *radius;
    }
    double numbers[5] = {0.0, 1.0, 0.0, 0.0, 0.0};
    static constexpr const char* kNames[5] = {"the gap", "the index", "the V-number", "semi_ap",
                                              "the coating"};
    for (std::size_t i = 1; i < words.size(); ++i) {
        const Result<double> number = RequireNumber(words[i], kNames[i - 1], line.number);
        if (!number) return number.error();
        numbers[i - 1] = *number;
    }
    out.gap_mm = numbers[0];
    SetMedium(out, numbers[1], numbers[2]);
    out.semi_diameter_mm = numbers[3];
    if (numbers[4] != 0.0) ++coated;
    return out;
}

}  // namespace

Result<LensDraft> ReadFlareSim(std::string_view text) {
    LensDraft draft;
    bool in_surfaces = false;
    std::optional<double> f_number;
    std::size_t coated = 0;
    std::vector<std::string> unread;
    for (const TextLine& line : LinesOf(text)) {
        const std::string lower = LowerCase(line.text);
        const auto value = [&line] {
            const std::string_view rest = line.text.substr(line.text.find(':') + 1);
            return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
        };
        if (line.text.front() == '#') {
            if (!f_number) f_number = FNumberIn(line.text);
            if (lower.rfind("# patent:", 0) == 0) draft.lens.patent = std::string(value());
        } else if (in_surfaces) {
            Result<SurfacePrescription> surface = RowOf(line, coated);
            if (!surface) return surface.error();
            draft.lens.surfaces.push_back(std::move(*surface));
            if (draft.lens.surfaces.size() > static_cast<std::size_t>(kMaxSurfaces)) {
                return Error{"bad_lens",
                             "the lens has more than " + std::to_string(kMaxSurfaces) + " surfaces",
                             LinePlace(line.number)};
            }
        } else if (lower.rfind("surfaces:", 0) == 0) {
            in_surfaces = true;
        } else if (lower.rfind("name:", 0) == 0) {
            draft.title = std::string(value());
            if (!f_number) f_number = FNumberIn(value());
        } else if (lower.rfind("focal_length:", 0) == 0) {
            const Result<double> focal = RequireNumber(value(), "focal_length", line.number);
            if (!focal) return focal.error();
            if (*focal > 0.0) draft.lens.design_focal_mm = *focal;
        } else {
            unread.push_back(Quoted(line.text));
        }
    }
    if (!in_surfaces || draft.lens.surfaces.empty()) {
        return Error{"bad_lens", "the file has no rows behind \"surfaces:\"", ""};
    }
    draft.lens.surfaces.back().gap_given = draft.lens.surfaces.back().gap_mm != 0.0;
    draft.lens.design_f_number = f_number;
    SettleApertures(draft, ApertureColumn::kSemiDiameters, f_number);
    if (coated > 0) {
        draft.Remark("The coating codes of " + std::to_string(coated) +
                     " rows are not carried over: they name no layers. Every surface is bare.");
    }
    if (!unread.empty()) {
        draft.Remark("Not read: " + unread.front() +
                     (unread.size() > 1 ? " and " + std::to_string(unread.size() - 1) +
                                              " more lines in front of the surfaces."
                                        : "."));
    }
    return draft;
}

}  // namespace flare
