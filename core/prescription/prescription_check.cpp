// SPDX-License-Identifier: Apache-2.0
//
// Four passes: what stops the lens from being built; what the table says against itself (surfaces
// that run into each other, glass without dispersion); what the built lens says against the figures
// that the file claims; and both again at every position of zoom and focus. The tolerances are wide
// enough for figures that a maker or a patent rounds, and narrow enough for the slips that occur:
// diameters taken for radii (f-number off by 2), a gap of another zoom setting (EFL off by 5 % and
// more), a focus that is not where the file says.
#include "core/prescription/prescription_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "core/base/units.h"
#include "core/optics/lens.h"
#include "core/optics/lens_state.h"
#include "core/optics/paraxial.h"
#include "core/optics/prescription_faults.h"

namespace flare {

namespace {

// Sag at height r from the axis in a section; beyond the surface's reach that at its edge.
double Sag(const SurfaceShape& shape, Section section, double r) {
    const double at = std::min(r, shape.reach_mm() * (1.0 - 1e-9));
    return section == Section::kX ? shape.Sag(at, 0.0) : shape.Sag(0.0, at);
}

class Linter {
  public:
    explicit Linter(const Prescription& prescription) : prescription_(prescription) {}

    std::vector<Finding> Run() {
        for (const PrescriptionFault& fault : FindFaults(prescription_)) {
            Add(Severity::kError, fault.code, fault.message, fault.where);
        }
        CheckText();
        if (findings_.empty() || findings_.front().severity != Severity::kError) {
            CheckSurfaces();
            const Result<std::shared_ptr<const Lens>> lens = Lens::Build(prescription_);
            if (!lens) {
                Add(Severity::kError, "first_order", lens.error().message, lens.error().where);
            } else {
                CheckFigures(**lens);
                CheckStates(*lens);
            }
        }
        std::stable_partition(findings_.begin(), findings_.end(), [](const Finding& finding) {
            return finding.severity == Severity::kError;
        });
        return std::move(findings_);
    }

  private:
    void Add(Severity severity, std::string code, std::string message, std::string where = "") {
        findings_.push_back({severity, std::move(code), std::move(message), std::move(where)});
    }
    void Warn(std::string code, std::string message, std::string where = "") {
        Add(Severity::kWarning, std::move(code), std::move(message), std::move(where));
    }

    void CheckText() {
        if (prescription_.source.empty()) {
            Warn("source", "the file does not say where its numbers come from (\"source\")");
        }
        const bool slug =
            std::all_of(prescription_.name.begin(), prescription_.name.end(), [](char c) {
                return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
            });
        if (!slug) {
            Warn("name", "the name \"" + prescription_.name +
                             "\" is not made of a-z, 0-9, - and _ as names in a library are");
        }
        if (!prescription_.design_focal_mm.has_value()) {
            Warn("design", "no design.focal_mm: the focal length cannot be checked");
        }
        if (!prescription_.design_f_number.has_value()) {
            Warn("design", "no design.f_number: the stop cannot be checked");
        }
    }

    void CheckSurfaces() {
        const std::vector<SurfacePrescription>& surfaces = prescription_.surfaces;
        const std::size_t optical = prescription_.optical_count();
        for (std::size_t i = 0; i < optical; ++i) {
            const SurfacePrescription& surface = surfaces[i];
            if (surface.nd.value_or(1.0) > 1.0 && !surface.vd.has_value()) {
                Warn("v_number",
                     SurfaceLabel(i) + ": glass of nd " + NumberText(*surface.nd) +
                         " without vd: it is traced without dispersion",
                     surface.where);
            }
            const double share = surface.semi_diameter_mm / ShapeOf(surface).reach_mm();
            if (share > kNearHemisphere) {
                Warn("semi_diameter",
                     SurfaceLabel(i) + ": the semi-diameter is " + NumberText(100.0 * share) +
                         " % of where the surface stands upright",
                     surface.where);
            }
            if (i + 1 < optical) CheckPair(i);
        }
    }

    struct Overlap {
        double by_mm = 0.0, at_mm = 0.0;  // below 0: that much room
    };
    // Surfaces i and i + 1 must not meet inside both clear apertures: the rays there would meet
    // them out of order.
    static Overlap OverlapOf(const SurfacePrescription& front, const SurfacePrescription& back) {
        const double shared = std::min(front.semi_diameter_mm, back.semi_diameter_mm);
        constexpr int kSteps = 64;
        const SurfaceShape front_shape = ShapeOf(front), back_shape = ShapeOf(back);
        Overlap most{-front.gap_mm, 0.0};
        for (const Section section : {Section::kX, Section::kY}) {
            for (int step = 1; step <= kSteps; ++step) {
                const double r = shared * step / kSteps;
                const double space =
                    front.gap_mm + Sag(back_shape, section, r) - Sag(front_shape, section, r);
                if (-space > most.by_mm) most = {-space, r};
            }
        }
        return most;
    }

    void WarnOfOverlap(std::size_t i, const Overlap& overlap, const std::string& when) {
        Warn("overlap",
             PairLabel(i) + " overlap by " + NumberText(overlap.by_mm) + " mm at " +
                 NumberText(overlap.at_mm) + " mm from the axis, inside both clear apertures" +
                 when,
             prescription_.surfaces[i + 1].where);
        overlapping_.insert(i);
    }

    static std::string PairLabel(std::size_t i) {
        return "surfaces " + std::to_string(i) + " and " + std::to_string(i + 1);
    }

    // An element should also have glass left at its wider rim.
    void CheckPair(std::size_t i) {
        const SurfacePrescription& front = prescription_.surfaces[i];
        const SurfacePrescription& back = prescription_.surfaces[i + 1];
        if (const Overlap overlap = OverlapOf(front, back); overlap.by_mm > kOverlapMm) {
            WarnOfOverlap(i, overlap, "");
            return;
        }
        const SurfaceShape front_shape = ShapeOf(front), back_shape = ShapeOf(back);
        if (MediumOf(front).value().is_air()) return;
        const double wide = std::max(front.semi_diameter_mm, back.semi_diameter_mm);
        double edge = front.gap_mm;
        for (const Section section : {Section::kX, Section::kY}) {
            edge = std::min(edge, front.gap_mm + Sag(back_shape, section, wide) -
                                      Sag(front_shape, section, wide));
        }
        if (edge < 0.0) {
            Warn("edge_thickness",
                 PairLabel(i) + ": their faces, continued to the wider rim (" + NumberText(wide) +
                     " mm), cross by " + NumberText(-edge) + " mm: the element has no edge",
                 front.where);
        }
    }

    void CheckAgainstDesign(const char* code, const char* what, double value, double design,
                            double warn, double fail, const std::string& when = "") {
        const double off = value / design - 1.0;
        if (std::abs(off) <= warn) return;
        char percent[32];
        std::snprintf(percent, sizeof percent, "%+.2f", 100.0 * off);
        Add(std::abs(off) > fail ? Severity::kError : Severity::kWarning, code,
            std::string(what) + when + " is " + NumberText(value) + " by the table but " +
                NumberText(design) + " by design (" + percent + " %)");
    }

    void CheckFigures(const Lens& lens) {
        const FirstOrder& first_order = lens.first_order();
        if (prescription_.design_focal_mm.has_value()) {
            CheckFocalLength(lens, *prescription_.design_focal_mm);
        }
        if (prescription_.design_f_number.has_value()) {
            CheckFNumber(lens, *prescription_.design_f_number);
        }

        const LensSurface& stop = lens.surfaces()[static_cast<std::size_t>(lens.stop_index())];
        const AxialBeam beam = WorkingBeam(lens, stop.semi_diameter_mm);
        const double passed = std::sqrt(lens.first_order(Section::kX).entrance.diameter_mm *
                                        first_order.entrance.diameter_mm);
        const double lost = 1.0 - beam.entrance_diameter_mm / passed;
        if (lost > kRimWarning) {
            Warn("rim", "rims cut the axial beam to " + NumberText(beam.entrance_diameter_mm) +
                            " mm where the stop would pass " + NumberText(passed) + " mm (" +
                            NumberText(100.0 * lost) + " % less)");
        }

        if (std::isinf(first_order.bfl_mm)) return;
        CheckSections(lens, beam);
        CheckFocus(lens, {}, "");
    }

    void CheckFocalLength(const Lens& lens, double design, const std::string& when = "") {
        const double tolerance = prescription_.focal_tolerance.value_or(kEflWarning);
        CheckAgainstDesign("efl", "the focal length in mm",
                           lens.first_order(prescription_.design_section).efl_mm, design, tolerance,
                           std::max(tolerance, kEflError), when);
    }

    void CheckFNumber(const Lens& lens, double design, const std::string& when = "") {
        const double tolerance = prescription_.f_number_tolerance.value_or(kFNumberWarning);
        CheckAgainstDesign("f_number", "the f-number that the stop gives", lens.f_number(), design,
                           tolerance, std::max(tolerance, kFNumberError), when);
    }

    // How far behind the last vertex a point on the axis is imaged that lies `focus_m` in front of
    // the sensor (absent: at infinity), midway between the two sections.
    static double ImageDistance(const Lens& lens, std::optional<double> focus_m) {
        double sum = 0.0;
        for (const Section section : {Section::kX, Section::kY}) {
            if (!focus_m) {
                sum += lens.first_order(section).bfl_mm;
                continue;
            }
            const Abcd whole = FrontToBack(lens, kLineD, section);
            const double object = *focus_m * kMmPerMetre - lens.sensor_z_mm();
            sum -= (whole.a * object + whole.b) / (whole.c * object + whole.d);
        }
        return 0.5 * sum;
    }

    void CheckFocus(const Lens& lens, std::optional<double> focus_m, const std::string& when) {
        const SurfacePrescription& last = prescription_.surfaces[prescription_.optical_count() - 1];
        if (!last.gap_given && !focus_m) return;
        const LensSurface& stop = lens.surfaces()[static_cast<std::size_t>(lens.stop_index())];
        const double defocus = lens.sensor_gap_mm() - ImageDistance(lens, focus_m);
        const double blur =
            std::abs(defocus) / WorkingBeam(lens, stop.semi_diameter_mm).working_f_number;
        if (!(blur > kFocusBlurMm)) return;
        Warn("focus",
             "the sensor stands " + NumberText(std::abs(defocus)) + " mm " +
                 (defocus > 0.0 ? "behind" : "in front of") + " the paraxial focus" + when +
                 ": a point becomes a disc of " + NumberText(blur) + " mm wide open",
             last.where);
    }

    // The positions of zoom and focus other than the first, where the surfaces stand as listed.
    void CheckStates(const std::shared_ptr<const Lens>& base) {
        const StateTable& table = prescription_.states;
        for (std::size_t zoom = 0; zoom < table.zoom_positions(); ++zoom) {
            for (std::size_t focus = 0; focus < table.focus_positions(); ++focus) {
                LensState state;
                std::string when;
                if (!table.focal_mm.empty()) {
                    state.zoom_mm = table.focal_mm[zoom];
                    when += " at " + NumberText(*state.zoom_mm) + " mm";
                }
                if (focus > 0) {
                    state.focus_m = table.focus_m[focus];
                    when += " focused to " + NumberText(*state.focus_m) + " m";
                }
                if (when.empty()) continue;
                const Result<LensInState> set = SetState(base, state);
                if (!set) {
                    Add(Severity::kError, "states", "the lens" + when + ": " + set.error().message,
                        set.error().where);
                    continue;
                }
                CheckState(*set->lens, state, zoom, when);
            }
        }
    }

    void CheckState(const Lens& lens, const LensState& state, std::size_t zoom,
                    const std::string& when) {
        const StateTable& table = prescription_.states;
        const bool first = zoom == 0 && !state.focus_m;
        if (!state.focus_m && !(first && prescription_.design_focal_mm == state.zoom_mm)) {
            CheckFocalLength(lens, *state.zoom_mm, when);
        }
        if (!state.focus_m && !table.f_number.empty() &&
            !(first && prescription_.design_f_number == table.f_number[zoom])) {
            CheckFNumber(lens, table.f_number[zoom], when);
        }
        if (first) return;
        CheckFocus(lens, state.focus_m, when);
        const std::vector<SurfacePrescription>& surfaces = lens.prescription().surfaces;
        for (std::size_t i = 0; i + 1 < prescription_.optical_count(); ++i) {
            if (overlapping_.count(i) > 0) continue;  // said once is enough
            const Overlap overlap = OverlapOf(surfaces[i], surfaces[i + 1]);
            if (overlap.by_mm > kOverlapMm) WarnOfOverlap(i, overlap, when);
        }
    }

    // The two sections of an anamorphic lens should have one focus.
    void CheckSections(const Lens& lens, const AxialBeam& beam) {
        const double apart = lens.first_order(Section::kX).bfl_mm - lens.first_order().bfl_mm;
        const double blur = 0.5 * std::abs(apart) / beam.working_f_number;
        if (!(blur > kFocusBlurMm)) return;
        Warn("astigmatism", "the foci of the x and y sections lie " + NumberText(std::abs(apart)) +
                                " mm apart: a point becomes a line of " + NumberText(blur) +
                                " mm wide open");
    }

    const Prescription& prescription_;
    std::vector<Finding> findings_;
    std::set<std::size_t> overlapping_;  // front surfaces of the pairs found to overlap
};

}  // namespace

std::vector<Finding> CheckPrescription(const Prescription& prescription) {
    return Linter(prescription).Run();
}

}  // namespace flare
