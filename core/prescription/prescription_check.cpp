// SPDX-License-Identifier: Apache-2.0
//
// Three passes: what stops the lens from being built; what the table says against itself (surfaces
// that run into each other, glass without dispersion); and what the built lens says against the
// figures that the file claims. The tolerances are wide enough for figures that a maker or a patent
// rounds, and narrow enough for the slips that occur: diameters taken for radii (f-number off by
// 2), a gap of another zoom setting (EFL off by 5 % and more), a focus that is not where the file
// says.
#include "core/prescription/prescription_check.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/optics/lens.h"
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

    // Surfaces i and i + 1 must not meet inside both clear apertures: the rays there would meet
    // them out of order. An element should also have glass left at its wider rim.
    void CheckPair(std::size_t i) {
        const SurfacePrescription& front = prescription_.surfaces[i];
        const SurfacePrescription& back = prescription_.surfaces[i + 1];
        const double shared = std::min(front.semi_diameter_mm, back.semi_diameter_mm);
        constexpr int kSteps = 64;
        const SurfaceShape front_shape = ShapeOf(front), back_shape = ShapeOf(back);
        double least = front.gap_mm, at = 0.0;
        for (const Section section : {Section::kX, Section::kY}) {
            for (int step = 1; step <= kSteps; ++step) {
                const double r = shared * step / kSteps;
                const double space =
                    front.gap_mm + Sag(back_shape, section, r) - Sag(front_shape, section, r);
                if (space < least) {
                    least = space;
                    at = r;
                }
            }
        }
        const std::string pair = "surfaces " + std::to_string(i) + " and " + std::to_string(i + 1);
        if (least < -kOverlapMm) {
            Warn("overlap",
                 pair + " overlap by " + NumberText(-least) + " mm at " + NumberText(at) +
                     " mm from the axis, inside both clear apertures",
                 back.where);
            return;
        }
        if (MediumOf(front).value().is_air()) return;
        const double wide = std::max(front.semi_diameter_mm, back.semi_diameter_mm);
        double edge = front.gap_mm;
        for (const Section section : {Section::kX, Section::kY}) {
            edge = std::min(edge, front.gap_mm + Sag(back_shape, section, wide) -
                                      Sag(front_shape, section, wide));
        }
        if (edge < 0.0) {
            Warn("edge_thickness",
                 pair + ": their faces, continued to the wider rim (" + NumberText(wide) +
                     " mm), cross by " + NumberText(-edge) + " mm: the element has no edge",
                 front.where);
        }
    }

    void CheckAgainstDesign(const char* code, const char* what, double value, double design,
                            double warn, double fail) {
        const double off = value / design - 1.0;
        if (std::abs(off) <= warn) return;
        char percent[32];
        std::snprintf(percent, sizeof percent, "%+.2f", 100.0 * off);
        Add(std::abs(off) > fail ? Severity::kError : Severity::kWarning, code,
            std::string(what) + " is " + NumberText(value) + " by the table but " +
                NumberText(design) + " by design (" + percent + " %)");
    }

    void CheckFigures(const Lens& lens) {
        const FirstOrder& first_order = lens.first_order();
        if (prescription_.design_focal_mm.has_value()) {
            const double tolerance = prescription_.focal_tolerance.value_or(kEflWarning);
            CheckAgainstDesign("efl", "the focal length in mm",
                               lens.first_order(prescription_.design_section).efl_mm,
                               *prescription_.design_focal_mm, tolerance,
                               std::max(tolerance, kEflError));
        }
        if (prescription_.design_f_number.has_value()) {
            const double tolerance = prescription_.f_number_tolerance.value_or(kFNumberWarning);
            CheckAgainstDesign("f_number", "the f-number that the stop gives", lens.f_number(),
                               *prescription_.design_f_number, tolerance,
                               std::max(tolerance, kFNumberError));
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
        const SurfacePrescription& last = prescription_.surfaces[prescription_.optical_count() - 1];
        CheckSections(lens, beam);
        if (!last.gap_given) return;
        const double focus = 0.5 * (lens.first_order(Section::kX).bfl_mm + first_order.bfl_mm);
        const double defocus = last.gap_mm - focus;
        const double blur = std::abs(defocus) / beam.working_f_number;
        if (blur > kFocusBlurMm) {
            Warn("focus",
                 "the sensor stands " + NumberText(std::abs(defocus)) + " mm " +
                     (defocus > 0.0 ? "behind" : "in front of") +
                     " the paraxial focus: a point becomes a disc of " + NumberText(blur) +
                     " mm wide open",
                 last.where);
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
};

}  // namespace

std::vector<Finding> CheckPrescription(const Prescription& prescription) {
    return Linter(prescription).Run();
}

}  // namespace flare
