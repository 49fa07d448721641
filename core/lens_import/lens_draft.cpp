// SPDX-License-Identifier: Apache-2.0
//
// Semi-diameters that a file leaves to its program are worked out as such programs do: the
// paraxial marginal ray of the stated pupil and the chief ray of the largest field, so that no rim
// vignettes. They are guesses about the mounts, and the remarks say so.
#include "core/lens_import/lens_draft.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/units.h"
#include "core/lens_import/text_lines.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

// Further out a paraxial chief ray says nothing.
constexpr double kMaxFieldDeg = 60.0;
// Of the radius: rims that are worked out stay below.
constexpr double kWidestRim = 0.95;
constexpr std::size_t kMaxProseBytes = 4000;  // of a remark, or of the file's own notes

// Paraxial heights at every surface and the slope behind the last, at the d line.
struct Passage {
    std::vector<double> heights;
    double slope = 0.0;
};

Passage Through(const std::vector<SurfacePrescription>& surfaces, const std::vector<double>& nd,
                double height, double slope) {
    Passage out;
    double index = 1.0;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        out.heights.push_back(height);
        const double radius = surfaces[i].radius_mm;
        const double power = radius == 0.0 ? 0.0 : (nd[i] - index) / radius;
        slope = (index * slope - height * power) / nd[i];
        index = nd[i];
        height += surfaces[i].gap_mm * slope;
    }
    out.slope = slope;
    return out;
}

Result<std::vector<double>> IndicesOf(const std::vector<SurfacePrescription>& surfaces) {
    std::vector<double> nd;
    for (const SurfacePrescription& surface : surfaces) {
        const Result<Glass> medium = MediumOf(surface);
        if (!medium) {
            return Error{"bad_lens", SurfaceLabel(nd.size()) + ": " + medium.error().message,
                         surface.where};
        }
        nd.push_back(medium->nd());
    }
    return nd;
}

std::optional<std::size_t> StopOf(const std::vector<SurfacePrescription>& surfaces) {
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        if (surfaces[i].kind == SurfaceKind::kStop) return i;
    }
    return std::nullopt;
}

// A flat stop at the vertex of a surface, on the side to which the surface does not bulge.
void PutStopAt(LensDraft& draft, std::size_t at) {
    std::vector<SurfacePrescription>& surfaces = draft.lens.surfaces;
    SurfacePrescription stop;
    stop.kind = SurfaceKind::kStop;
    stop.gap_given = true;
    stop.semi_diameter_mm = surfaces[at].semi_diameter_mm;
    stop.where = surfaces[at].where;
    const bool behind = surfaces[at].radius_mm < 0.0;
    const auto take_medium = [&stop](const SurfacePrescription& from) {
        stop.glass = from.glass;
        stop.nd = from.nd;
        stop.vd = from.vd;
    };
    if (behind) {
        take_medium(surfaces[at]);
        stop.gap_mm = surfaces[at].gap_mm;
        stop.gap_given = surfaces[at].gap_given;
        surfaces[at].gap_mm = 0.0;
        surfaces[at].gap_given = true;
    } else if (at > 0) {
        take_medium(surfaces[at - 1]);
    }
    surfaces.insert(surfaces.begin() + static_cast<std::ptrdiff_t>(at + (behind ? 1 : 0)), stop);
    draft.Remark(
        "The file has its stop on a refracting surface; here it is a flat stop of its "
        "own, surface " +
        std::to_string(at + (behind ? 1 : 0)) + ", at that surface's vertex.");
}

// The diameter of the entrance pupil, from whatever the file says.
std::optional<double> PupilOf(const LensDraft& draft, const Passage& unit, std::size_t stop) {
    if (draft.pupil_mm) return draft.pupil_mm;
    if (draft.f_number && unit.slope != 0.0) return std::abs(1.0 / (unit.slope * *draft.f_number));
    const double semi = draft.lens.surfaces[stop].semi_diameter_mm;
    if (semi > 0.0 && unit.heights[stop] != 0.0) return 2.0 * semi / std::abs(unit.heights[stop]);
    return std::nullopt;
}

std::optional<Error> WorkOutRims(LensDraft& draft) {
    std::vector<SurfacePrescription>& surfaces = draft.lens.surfaces;
    const auto missing = [](const SurfacePrescription& surface) {
        return surface.semi_diameter_mm == 0.0;
    };
    if (std::none_of(surfaces.begin(), surfaces.end(), missing)) return std::nullopt;
    const Result<std::vector<double>> nd = IndicesOf(surfaces);
    if (!nd) return nd.error();
    const std::optional<std::size_t> stop = StopOf(surfaces);
    if (!stop) {
        return Error{"bad_lens", "the file has no stop, without which rims cannot be worked out",
                     ""};
    }
    const Passage unit = Through(surfaces, *nd, 1.0, 0.0);
    const std::optional<double> pupil = PupilOf(draft, unit, *stop);
    const auto first = std::find_if(surfaces.begin(), surfaces.end(), missing);
    if (!pupil || !(*pupil > 0.0)) {
        return Error{"bad_lens",
                     "the file has neither the semi-diameter of this surface nor an entrance pupil "
                     "or f-number",
                     first->where};
    }
    double tangent = 0.0;
    if (draft.field_deg) {
        tangent = std::tan(std::min(std::abs(*draft.field_deg), kMaxFieldDeg) * kPi / 180.0);
    } else if (draft.image_height_mm) {
        tangent = std::abs(*draft.image_height_mm * unit.slope);
    }
    const Passage tilted = Through(surfaces, *nd, 0.0, tangent);
    const double at_front =
        unit.heights[*stop] == 0.0 ? 0.0 : -tilted.heights[*stop] / unit.heights[*stop];
    const Passage chief = Through(surfaces, *nd, at_front, tangent);
    std::vector<std::size_t> made;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        if (!missing(surfaces[i])) continue;
        const double marginal = 0.5 * *pupil * std::abs(unit.heights[i]);
        double semi = i == *stop ? marginal : marginal + std::abs(chief.heights[i]);
        const double radius = std::abs(surfaces[i].radius_mm);
        if (radius > 0.0) semi = std::min(semi, kWidestRim * radius);
        surfaces[i].semi_diameter_mm = semi;
        made.push_back(i);
    }
    draft.Remark("The file does not fix the semi-diameter of " + SurfaceList(made) +
                 "; worked out from an entrance pupil of " + NumberText(*pupil) + " mm" +
                 (tangent > 0.0 ? " and a field of " +
                                      NumberText(std::atan(tangent) * 180.0 / kPi) + " degrees"
                                : " on the axis alone, since no field is given") +
                 ": guesses, without vignetting.");
    return std::nullopt;
}

std::string SlugOf(std::string_view title) {
    std::string out;
    for (const char c : LowerCase(title)) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
        if (plain) {
            out += c;
        } else if (!out.empty() && out.back() != '-') {
            out += '-';
        }
        if (out.size() >= 60) break;
    }
    while (!out.empty() && out.back() == '-') out.pop_back();
    return out.empty() ? "imported-lens" : out;
}

// Prose of an outside file: control characters would not be legal in a lens file.
std::string Clean(std::string_view text) {
    std::string out;
    for (const char c : text.substr(0, kMaxProseBytes)) {
        const auto byte = static_cast<unsigned char>(c);
        out += byte < 0x20 || byte >= 0x7f ? '?' : c;
    }
    return out;
}

// Scaling and inverting can leave what a double can hold.
std::optional<Error> FindEndless(const Prescription& lens) {
    const auto finite = [](const std::optional<double>& value) {
        return !value || std::isfinite(*value);
    };
    for (std::size_t i = 0; i < lens.surfaces.size(); ++i) {
        const SurfacePrescription& surface = lens.surfaces[i];
        const bool sound = std::isfinite(surface.radius_mm) && std::isfinite(surface.gap_mm) &&
                           std::isfinite(surface.semi_diameter_mm) &&
                           std::isfinite(surface.conic) && finite(surface.nd) &&
                           finite(surface.vd) &&
                           std::all_of(surface.asphere.begin(), surface.asphere.end(),
                                       [](double term) { return std::isfinite(term); });
        if (!sound) {
            return Error{"bad_lens", SurfaceLabel(i) + " has a number beyond all bounds",
                         surface.where};
        }
    }
    if (!finite(lens.design_focal_mm) || !finite(lens.design_f_number)) {
        return Error{"bad_lens", "the focal length or f-number is beyond all bounds", ""};
    }
    return std::nullopt;
}

}  // namespace

void RemarkUnread(LensDraft& draft, const std::set<std::string>& names) {
    if (names.empty()) return;
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
    draft.Remark("Not read: " + list + ".");
}

void RemarkBare(LensDraft& draft) {
    draft.Remark("The file has no coatings that could be carried over: every surface is bare.");
}

std::string SurfaceList(const std::vector<std::size_t>& surfaces) {
    std::string out = surfaces.size() == 1 ? "surface " : "surfaces ";
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        if (i > 0) out += i + 1 == surfaces.size() ? " and " : ", ";
        out += std::to_string(surfaces[i]);
    }
    return out;
}

void SettleApertures(LensDraft& draft, ApertureColumn stated, std::optional<double> f_number) {
    std::vector<SurfacePrescription>& surfaces = draft.lens.surfaces;
    const auto name = [](bool diameters) {
        return std::string(diameters ? "diameters" : "semi-diameters");
    };
    bool diameters = stated == ApertureColumn::kDiameters;
    const std::optional<std::size_t> stop = StopOf(surfaces);
    const Result<std::vector<double>> nd = IndicesOf(surfaces);
    std::optional<double> ratio;
    if (f_number && stop && nd.ok()) {
        const Passage unit = Through(surfaces, *nd, 1.0, 0.0);
        const double wanted = std::abs(unit.heights[*stop] / (2.0 * *f_number * unit.slope));
        if (std::isfinite(wanted) && wanted > 0.0) {
            ratio = surfaces[*stop].semi_diameter_mm / wanted;
        }
    }
    const std::string measured =
        ratio ? "the stop's, " + NumberText(surfaces[*stop].semi_diameter_mm) + ", is " +
                    NumberText(*ratio) + " times the semi-diameter that f/" +
                    NumberText(*f_number) + " asks for"
              : "";
    // 1 and 2 are what it may be; halfway between and outside it says nothing.
    const bool tells = ratio && *ratio > std::sqrt(0.5) && *ratio < std::sqrt(8.0);
    if (tells) {
        diameters = *ratio > std::sqrt(2.0);
        const bool contradicted = diameters != (stated == ApertureColumn::kDiameters);
        draft.Remark("The apertures were read as " + name(diameters) + ": " + measured +
                     (contradicted ? ", though the file calls them " + name(!diameters) : "") +
                     ".");
    } else {
        const bool too_wide =
            std::any_of(surfaces.begin(), surfaces.end(), [](const SurfacePrescription& surface) {
                return surface.radius_mm != 0.0 &&
                       surface.semi_diameter_mm >= std::abs(surface.radius_mm);
            });
        diameters = diameters || too_wide;
        draft.Remark(
            "The apertures were read as " + name(diameters) +
            (too_wide ? ", since one is wider than its sphere; " : ", as such files have them; ") +
            (ratio ? measured + ", which fits neither reading."
                   : "the file has no f-number to check that against."));
    }
    if (!diameters) return;
    for (SurfacePrescription& surface : surfaces) surface.semi_diameter_mm *= 0.5;
}

void DropDummies(LensDraft& draft) {
    std::vector<SurfacePrescription>& surfaces = draft.lens.surfaces;
    std::vector<SurfacePrescription> kept;
    std::vector<std::size_t> dropped;
    std::optional<std::size_t> stop_on;
    const SurfacePrescription air;
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const SurfacePrescription& before = i == 0 ? air : surfaces[i - 1];
        const SurfacePrescription& surface = surfaces[i];
        const bool refracts =
            surface.glass != before.glass || surface.nd != before.nd || surface.vd != before.vd;
        const bool stop = surface.kind == SurfaceKind::kStop || draft.stop_on == i;
        if (refracts || stop || surface.semi_diameter_mm > 0.0) {
            if (draft.stop_on == i) stop_on = kept.size();
            kept.push_back(surface);
            continue;
        }
        dropped.push_back(i);
        if (kept.empty()) continue;  // in front of the lens it only says where the drawing begins
        kept.back().gap_mm += surface.gap_mm;
        kept.back().gap_given = surface.gap_given;
    }
    if (dropped.empty()) return;
    draft.Remark("Left out since they refract nothing and have no rim: " + SurfaceList(dropped) +
                 " of the file.");
    surfaces = std::move(kept);
    draft.stop_on = stop_on;
}

void ScaleLengths(LensDraft& draft, double factor) {
    for (SurfacePrescription& surface : draft.lens.surfaces) {
        surface.radius_mm *= factor;
        surface.gap_mm *= factor;
        surface.semi_diameter_mm *= factor;
        double power = std::pow(factor, -3.0);
        for (double& coefficient : surface.asphere) {
            coefficient *= power;
            power /= factor * factor;
        }
    }
    for (std::optional<double>* length :
         {&draft.lens.design_focal_mm, &draft.pupil_mm, &draft.image_height_mm}) {
        if (*length) **length *= factor;
    }
}

void SetMedium(SurfacePrescription& surface, double nd, std::optional<double> vd) {
    if (nd == 1.0) return;
    surface.nd = nd;
    if (vd && *vd != 0.0) surface.vd = *vd;
}

void StandInMediumInFront(SurfacePrescription& stop,
                          const std::vector<SurfacePrescription>& in_front) {
    if (in_front.empty()) return;
    stop.glass = in_front.back().glass;
    stop.nd = in_front.back().nd;
    stop.vd = in_front.back().vd;
}

Result<ImportedLens> FinishDraft(LensDraft draft, LensFormat format) {
    std::vector<SurfacePrescription>& surfaces = draft.lens.surfaces;
    if (surfaces.empty()) return Error{"bad_lens", "the file has no surfaces", ""};
    if (draft.stop_on) {
        SurfacePrescription& on = surfaces[*draft.stop_on];
        const SurfacePrescription air;
        const SurfacePrescription& before =
            *draft.stop_on == 0 ? air : surfaces[*draft.stop_on - 1];
        const bool refracts = on.glass != before.glass || on.nd != before.nd || on.vd != before.vd;
        if (refracts) {
            PutStopAt(draft, *draft.stop_on);
        } else {
            if (on.radius_mm != 0.0) draft.Remark("The file's curved stop is a flat one here.");
            on.kind = SurfaceKind::kStop;
            on.radius_mm = on.conic = 0.0;
            on.asphere.clear();
        }
    }
    if (surfaces.size() > static_cast<std::size_t>(kMaxSurfaces)) {
        return Error{"bad_lens",
                     "the lens has " + std::to_string(surfaces.size()) +
                         " surfaces; the limit is " + std::to_string(kMaxSurfaces),
                     surfaces[static_cast<std::size_t>(kMaxSurfaces)].where};
    }
    for (SurfacePrescription& surface : surfaces) {
        if (surface.kind == SurfaceKind::kSphere && surface.radius_mm == 0.0) {
            surface.kind = SurfaceKind::kPlane;
        }
    }
    if (const std::optional<Error> error = WorkOutRims(draft)) return *error;
    if (const std::optional<Error> error = FindEndless(draft.lens)) return *error;

    Prescription& lens = draft.lens;
    for (std::optional<double>* claim : {&lens.design_focal_mm, &lens.design_f_number}) {
        if (*claim && !(**claim > 0.0)) claim->reset();  // no claim at all
    }
    lens.name = SlugOf(draft.title);
    lens.maker = Clean(lens.maker);
    lens.patent = Clean(lens.patent);
    lens.source = "Imported from a file in the format \"" + std::string(FormatName(format)) + "\"" +
                  (draft.title.empty() ? "." : ", there called " + Quoted(draft.title) + ".");
    std::string notes = Clean(lens.notes);
    for (std::string& remark : draft.remarks) {
        remark = Clean(remark);
        notes += (notes.empty() ? "" : "\n") + remark;
    }
    lens.notes = notes;
    return ImportedLens{format, std::move(lens), std::move(draft.remarks)};
}

}  // namespace flare
