// SPDX-License-Identifier: Apache-2.0
#include "core/optics/prescription_faults.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "core/optics/coating_design.h"
#include "core/optics/glass_catalogue.h"
#include "core/optics/lens_state.h"

namespace flare {

std::string SurfaceLabel(std::size_t index) {
    return "surface " + std::to_string(index);
}

std::string NumberText(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

Result<Glass> MediumOf(const SurfacePrescription& surface) {
    const auto fault = [&](const char* code, std::string message) {
        return Error{code, std::move(message), surface.where};
    };
    if (surface.glass.has_value()) {
        if (surface.nd.has_value() || surface.vd.has_value()) {
            return fault("glass", "glass is given together with nd or vd");
        }
        Result<Glass> named = GlassByName(*surface.glass);
        if (!named) return fault("glass", named.error().message);
        return named;
    }
    const double nd = surface.nd.value_or(1.0);
    if (!(nd >= 1.0 && nd <= kMaxNd)) {
        return fault("index", "the index nd = " + NumberText(nd) + " is not within 1 .. " +
                                  NumberText(kMaxNd));
    }
    if (!surface.vd.has_value()) return Glass::FromNdVd(nd, std::nullopt);
    if (!surface.nd.has_value()) return fault("index", "vd is given without nd");
    if (!(*surface.vd >= kMinVd && *surface.vd <= kMaxVd)) {
        return fault("v_number", "the V-number vd = " + NumberText(*surface.vd) +
                                     " is not within " + NumberText(kMinVd) + " .. " +
                                     NumberText(kMaxVd));
    }
    return Glass::FromNdVd(nd, surface.vd);
}

namespace {

// Collects the faults of one prescription.
class FaultFinder {
  public:
    explicit FaultFinder(const Prescription& prescription) : prescription_(prescription) {}

    std::vector<PrescriptionFault> Run() {
        const std::size_t count = prescription_.surfaces.size();
        const std::size_t optical = prescription_.optical_count();
        for (const SurfacePrescription& surface : prescription_.surfaces) {
            media_.push_back(MediumOf(surface));
        }
        for (index_ = 0; index_ < count; ++index_) {
            const SurfacePrescription& surface = prescription_.surfaces[index_];
            CheckShape(surface);
            CheckSensor(surface, index_ + 1 == count);
            if (index_ < optical) CheckGap(surface, index_ + 1 == optical);
            CheckMedium(surface);
            CheckCoating(surface);
        }
        CheckWhole();
        return std::move(faults_);
    }

  private:
    void Add(const char* code, const std::string& message) {
        faults_.push_back(
            {code, SurfaceLabel(index_) + ": " + message, prescription_.surfaces[index_].where});
    }

    void CheckShape(const SurfacePrescription& surface) {
        const SurfaceKind kind = surface.kind;
        const bool flat = kind == SurfaceKind::kPlane || kind == SurfaceKind::kStop ||
                          kind == SurfaceKind::kSensor;
        const bool toroid = kind == SurfaceKind::kToroid;
        CheckRadius("radius_mm", surface.radius_mm);
        CheckRadius("radius_x_mm", surface.radius_x_mm);
        CheckRadius("radius_y_mm", surface.radius_y_mm);
        if ((flat || toroid) && surface.radius_mm != 0.0) {
            Add("radius", "a " + std::string(KindName(kind)) +
                              (flat ? " is flat" : " has two radii") + ", but radius_mm is " +
                              NumberText(surface.radius_mm));
        }
        if (!toroid && (surface.radius_x_mm != 0.0 || surface.radius_y_mm != 0.0)) {
            Add("radius", "radius_x_mm and radius_y_mm are for a toroid");
        }
        CheckAsphere(surface);
        CheckSemiDiameter(surface);
    }

    void CheckRadius(const char* key, double radius) {
        if (std::isnan(radius)) {
            Add("radius", std::string(key) + " is not a number");
        } else if (radius != 0.0 && std::abs(radius) < kMinLengthMm) {
            Add("radius", "the radius " + NumberText(radius) + " mm is too small to be one");
        }
    }

    void CheckAsphere(const SurfacePrescription& surface) {
        const bool given = surface.conic != 0.0 || !surface.asphere.empty();
        if (given && surface.kind != SurfaceKind::kAsphere) {
            Add("asphere", "conic and asphere are for the kind \"asphere\", not for \"" +
                               std::string(KindName(surface.kind)) + "\"");
        }
        if (!(std::abs(surface.conic) <= kMaxConic)) {
            Add("asphere", "the conic constant " + NumberText(surface.conic) + " is not within +-" +
                               NumberText(kMaxConic));
        }
        if (surface.asphere.size() > SurfaceShape::kMostCoefficients) {
            Add("asphere",
                "an asphere has at most " + std::to_string(SurfaceShape::kMostCoefficients) +
                    " coefficients (a4 ... a18), not " + std::to_string(surface.asphere.size()));
        }
        // What counts is what a coefficient does to the sag at the rim.
        double power = std::pow(surface.semi_diameter_mm, 4.0);
        for (std::size_t i = 0; i < surface.asphere.size(); ++i) {
            const double sag = std::abs(surface.asphere[i]) * power;
            power *= surface.semi_diameter_mm * surface.semi_diameter_mm;
            if (!(sag <= kMaxAsphericSags * surface.semi_diameter_mm)) {
                Add("asphere", "a" + std::to_string(2 * i + 4) + " = " +
                                   NumberText(surface.asphere[i]) + " bends the rim by " +
                                   NumberText(sag) + " mm: wrong by a power of ten?");
            }
        }
    }

    void CheckSemiDiameter(const SurfacePrescription& surface) {
        const double semi = surface.semi_diameter_mm;
        if (!(semi >= kMinLengthMm && semi <= kMaxSemiDiameterMm)) {
            Add("semi_diameter", "the semi-diameter " + NumberText(semi) + " mm is not within " +
                                     NumberText(kMinLengthMm) + " .. " +
                                     NumberText(kMaxSemiDiameterMm) + " mm");
            return;
        }
        if (std::isnan(surface.radius_mm) ||
            surface.asphere.size() > SurfaceShape::kMostCoefficients)
            return;
        const double reach = ShapeOf(surface).reach_mm();
        if (semi >= reach) {
            const bool sphere = surface.kind == SurfaceKind::kSphere;
            Add("semi_diameter",
                "the semi-diameter " + NumberText(semi) + " mm is not below " +
                    (sphere ? "the radius " + NumberText(surface.radius_mm) + " mm: no sphere"
                            : NumberText(reach) + " mm, where the surface stands upright: no " +
                                  std::string(KindName(surface.kind))) +
                    " is that wide (was a diameter meant?)");
        }
    }

    void CheckSensor(const SurfacePrescription& surface, bool last) {
        if (surface.kind != SurfaceKind::kSensor) {
            if (surface.reflectance != 0.0) {
                Add("sensor", "reflectance is for the kind \"sensor\"");
            }
            return;
        }
        if (!last) Add("sensor", "a sensor can only be the last surface");
        if (!(surface.reflectance >= 0.0 && surface.reflectance <= 1.0)) {
            Add("sensor",
                "the reflectance " + NumberText(surface.reflectance) + " is not within 0 .. 1");
        }
        if (surface.gap_given) Add("sensor", "behind the sensor there is no gap");
        if (surface.nd.has_value() || surface.glass.has_value() || surface.coating.has_value()) {
            Add("sensor", "a sensor has a reflectance, neither glass nor coating");
        }
    }

    void CheckGap(const SurfacePrescription& surface, bool last) {
        if (last && !surface.gap_given) return;
        const double gap = surface.gap_mm;
        if (!(gap >= 0.0 && gap <= kMaxGapMm)) {
            Add("gap", "the gap " + NumberText(gap) + " mm is not within 0 .. " +
                           NumberText(kMaxGapMm) + " mm");
        } else if (last && gap < kMinLengthMm) {
            Add("gap", "the sensor touches the last vertex (gap " + NumberText(gap) + " mm)");
        }
    }

    void CheckMedium(const SurfacePrescription& surface) {
        const Result<Glass>& medium = media_[index_];
        if (!medium) {
            Add(medium.error().code.c_str(), medium.error().message);
        } else if (surface.kind == SurfaceKind::kStop) {
            CheckStopMedium(*medium);
        }
    }

    void CheckStopMedium(const Glass& behind) {
        const Result<Glass> front = index_ == 0 ? Glass::Air() : media_[index_ - 1];
        if (front.ok() && !(*front == behind)) {
            Add("stop_medium", "the medium behind the stop (nd " + NumberText(behind.nd()) +
                                   ") is not the one in front of it (nd " +
                                   NumberText(front->nd()) + "): a stop does not refract");
        }
    }

    void CheckCoating(const SurfacePrescription& surface) {
        if (!surface.coating.has_value()) return;
        if (surface.kind == SurfaceKind::kStop) {
            Add("coating", "a stop has nothing to coat");
        } else if (const Result<CoatingDesign> coating =
                       CoatingDesignByName(*surface.coating, prescription_.coatings);
                   !coating) {
            Add("coating", coating.error().message);
        }
    }

    void AddWhole(const char* code, const std::string& message, const std::string& where = "") {
        faults_.push_back({code, message, where});
    }

    void CheckWhole() {
        const std::vector<SurfacePrescription>& surfaces = prescription_.surfaces;
        if (surfaces.empty()) {
            AddWhole("no_surface", "the lens has no surfaces");
            return;
        }
        if (surfaces.size() > static_cast<std::size_t>(kMaxSurfaces)) {
            AddWhole("surface_count", "the lens has " + std::to_string(surfaces.size()) +
                                          " surfaces; the limit is " +
                                          std::to_string(kMaxSurfaces));
        }
        if (const Result<CoatingDesign> coating =
                CoatingDesignByName(prescription_.default_coating, prescription_.coatings);
            !coating) {
            AddWhole("coating", "default_coating: " + coating.error().message);
        }
        if (prescription_.optical_count() == 0) {
            AddWhole("no_surface", "the lens has no surface but a sensor");
            return;
        }
        const std::size_t at = prescription_.optical_count() - 1;
        if (const Result<Glass>& last = media_[at]; last.ok() && !last->is_air()) {
            AddWhole("last_medium",
                     SurfaceLabel(at) +
                         ": behind the last surface there must be air, not glass of nd " +
                         NumberText(last->nd()),
                     surfaces[at].where);
        }
        CheckStops();
        for (const StateFault& fault : FindStateFaults(prescription_)) {
            AddWhole("states", fault.message, fault.where);
        }
    }

    void CheckStops() {
        int stops = 0, refracting = 0;
        Result<Glass> before = Glass::Air();
        for (std::size_t i = 0; i < prescription_.surfaces.size(); ++i) {
            const SurfacePrescription& surface = prescription_.surfaces[i];
            const Result<Glass>& behind = media_[i];
            const bool same = before.ok() && behind.ok() && *before == *behind;
            if (surface.kind != SurfaceKind::kStop && !same) ++refracting;
            if (surface.kind == SurfaceKind::kStop && ++stops == 2) {
                AddWhole("several_stops",
                         SurfaceLabel(i) +
                             ": a second aperture stop; lenses with more than one stop are not "
                             "supported yet",
                         surface.where);
            }
            before = behind;
        }
        if (stops == 0) {
            AddWhole("no_stop",
                     "the lens has no aperture stop: one surface must be of kind \"stop\"");
        }
        if (refracting == 0) AddWhole("no_glass", "no surface of the lens refracts light");
    }

    const Prescription& prescription_;
    std::size_t index_ = 0;
    std::vector<Result<Glass>> media_;  // behind each surface
    std::vector<PrescriptionFault> faults_;
};

}  // namespace

std::vector<PrescriptionFault> FindFaults(const Prescription& prescription) {
    return FaultFinder(prescription).Run();
}

}  // namespace flare
