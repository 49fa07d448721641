// SPDX-License-Identifier: Apache-2.0
#include "core/optics/prescription_faults.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "core/optics/coating_design.h"

namespace flare {

std::string SurfaceLabel(std::size_t index) {
    return "surface " + std::to_string(index);
}

std::string NumberText(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

namespace {

// Collects the faults of one prescription.
class FaultFinder {
  public:
    explicit FaultFinder(const Prescription& prescription) : prescription_(prescription) {}

    std::vector<PrescriptionFault> Run() {
        const std::size_t count = prescription_.surfaces.size();
        for (index_ = 0; index_ < count; ++index_) {
            const SurfacePrescription& surface = prescription_.surfaces[index_];
            CheckShape(surface);
            CheckGap(surface, index_ + 1 == count);
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
        const double radius = surface.radius_mm;
        const double semi = surface.semi_diameter_mm;
        if (std::isnan(radius)) {
            Add("radius", "the radius is not a number");
        } else if (surface.kind != SurfaceKind::kSphere && radius != 0.0) {
            Add("radius", std::string("a ") +
                              (surface.kind == SurfaceKind::kStop ? "stop" : "plane") +
                              " is flat, but radius_mm is " + NumberText(radius));
        } else if (radius != 0.0 && std::abs(radius) < kMinLengthMm) {
            Add("radius", "the radius " + NumberText(radius) + " mm is too small to be one");
        }
        if (!(semi >= kMinLengthMm && semi <= kMaxSemiDiameterMm)) {
            Add("semi_diameter", "the semi-diameter " + NumberText(semi) + " mm is not within " +
                                     NumberText(kMinLengthMm) + " .. " +
                                     NumberText(kMaxSemiDiameterMm) + " mm");
        } else if (surface.kind == SurfaceKind::kSphere && radius != 0.0 &&
                   semi >= std::abs(radius)) {
            Add("semi_diameter", "the semi-diameter " + NumberText(semi) +
                                     " mm is not below the radius " + NumberText(radius) +
                                     " mm: no sphere is that wide (was a diameter meant?)");
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
        const double nd = surface.nd.value_or(1.0);
        if (!(nd >= 1.0 && nd <= kMaxNd)) {
            Add("index",
                "the index nd = " + NumberText(nd) + " is not within 1 .. " + NumberText(kMaxNd));
        }
        if (surface.vd.has_value() && !surface.nd.has_value()) {
            Add("index", "vd is given without nd");
        } else if (surface.vd.has_value() && !(*surface.vd >= kMinVd && *surface.vd <= kMaxVd)) {
            Add("v_number", "the V-number vd = " + NumberText(*surface.vd) + " is not within " +
                                NumberText(kMinVd) + " .. " + NumberText(kMaxVd));
        }
        if (surface.kind == SurfaceKind::kStop) CheckStopMedium(surface);
    }

    void CheckStopMedium(const SurfacePrescription& stop) {
        const SurfacePrescription air;
        const SurfacePrescription& front = index_ == 0 ? air : prescription_.surfaces[index_ - 1];
        const double nd_front = front.nd.value_or(1.0), nd_behind = stop.nd.value_or(1.0);
        const bool same_dispersion =
            nd_behind == 1.0 || front.vd.value_or(0.0) == stop.vd.value_or(0.0);
        if (nd_front != nd_behind || !same_dispersion) {
            Add("stop_medium", "the medium behind the stop (nd " + NumberText(nd_behind) +
                                   ") is not the one in front of it (nd " + NumberText(nd_front) +
                                   "): a stop does not refract");
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
        if (surfaces.back().nd.value_or(1.0) != 1.0) {
            AddWhole("last_medium",
                     SurfaceLabel(surfaces.size() - 1) +
                         ": behind the last surface there must be air, not glass of nd " +
                         NumberText(*surfaces.back().nd),
                     surfaces.back().where);
        }
        CheckStops();
    }

    void CheckStops() {
        int stops = 0, refracting = 0;
        double before = 1.0;
        for (std::size_t i = 0; i < prescription_.surfaces.size(); ++i) {
            const SurfacePrescription& surface = prescription_.surfaces[i];
            const double behind = surface.nd.value_or(1.0);
            if (surface.kind != SurfaceKind::kStop && behind != before) ++refracting;
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
    std::vector<PrescriptionFault> faults_;
};

}  // namespace

std::vector<PrescriptionFault> FindFaults(const Prescription& prescription) {
    return FaultFinder(prescription).Run();
}

}  // namespace flare
