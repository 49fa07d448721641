// SPDX-License-Identifier: Apache-2.0
#include "core/optics/lens_coatings.h"

#include "core/optics/lens.h"

namespace flare {
namespace {

std::optional<Error> FaultOf(const CoatingOverride& coatings, const Prescription& prescription) {
    const auto fault_of_name = [&](const std::string& name, const std::string& where) {
        const Result<CoatingDesign> design = CoatingDesignByName(name, prescription.coatings);
        return design.ok() ? std::optional<Error>()
                           : Error{"bad_value", design.error().message, where};
    };
    if (coatings.default_coating.has_value()) {
        if (auto fault = fault_of_name(*coatings.default_coating, "/default")) return fault;
    }
    for (const auto& [surface, name] : coatings.surfaces) {
        const std::string where = "/surfaces/" + std::to_string(surface);
        const std::size_t count = prescription.optical_count();
        if (surface < 0 || static_cast<std::size_t>(surface) >= count) {
            return Error{"bad_value",
                         "there is no surface " + std::to_string(surface) +
                             ": the lens has surfaces 0 to " + std::to_string(count - 1),
                         where};
        }
        if (prescription.surfaces[static_cast<std::size_t>(surface)].kind == SurfaceKind::kStop) {
            return Error{"bad_value",
                         "surface " + std::to_string(surface) +
                             " is a stop, which has nothing to "
                             "coat",
                         where};
        }
        if (auto fault = fault_of_name(name, where)) return fault;
    }
    return std::nullopt;
}

}  // namespace

Coating CoatingFor(const Prescription& prescription, const SurfacePrescription& surface,
                   const Glass& before, const Glass& behind) {
    if (surface.kind == SurfaceKind::kStop || before.nd() == behind.nd()) return {};
    if (!surface.coating.has_value() && before.is_air() == behind.is_air()) return {};
    const std::string name = surface.coating.value_or(prescription.default_coating);
    const CoatingDesign design = CoatingDesignByName(name, prescription.coatings).value();
    return before.nd() < behind.nd() ? design.For(before, behind) : design.For(behind, before);
}

Result<std::shared_ptr<const Lens>> Lens::WithCoatings(const CoatingOverride& coatings) const {
    auto lens = std::make_shared<Lens>(*this);
    Prescription& prescription = lens->prescription_;
    for (const auto& [name, design] : coatings.coatings) prescription.coatings[name] = design;
    if (const std::optional<Error> fault = FaultOf(coatings, prescription)) return *fault;

    const auto air_meets_glass = [&](int i) {
        return MediumBefore(i).is_air() != MediumBehind(i).is_air();
    };
    const int count = static_cast<int>(surfaces_.size());
    if (coatings.default_coating.has_value()) {
        prescription.default_coating = *coatings.default_coating;
        for (int i = 0; i < count; ++i) {
            if (air_meets_glass(i)) {
                prescription.surfaces[static_cast<std::size_t>(i)].coating.reset();
            }
        }
    }
    for (const auto& [surface, name] : coatings.surfaces) {
        prescription.surfaces[static_cast<std::size_t>(surface)].coating = name;
    }
    for (int i = 0; i < count; ++i) {
        const auto s = static_cast<std::size_t>(i);
        lens->surfaces_[s].coating =
            CoatingFor(prescription, prescription.surfaces[s], MediumBefore(i), MediumBehind(i));
    }
    lens->Seal();
    return std::shared_ptr<const Lens>(std::move(lens));
}

}  // namespace flare
