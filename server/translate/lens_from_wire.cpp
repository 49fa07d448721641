// SPDX-License-Identifier: Apache-2.0
#include "server/translate/lens_from_wire.h"

#include "core/optics/lens_coatings.h"
#include "core/prescription/prescription_check.h"
#include "core/prescription/prescription_reader.h"
#include "protocol/limits.h"
#include "server/translate/document_from_json.h"

namespace flare {
namespace {

Result<std::shared_ptr<const Lens>> BuildInline(const wire::JsonTree& tree) {
    const auto at_root = [&](Error error) {
        if (error.where.empty()) error.where = tree.pointer;
        return error;
    };
    const Result<Prescription> prescription = ReadPrescription(DocumentFromJson(tree));
    if (!prescription) return at_root(prescription.error());
    if (prescription->name.size() > limits::kNameBytes) {
        return Error{"limit",
                     "the name is longer than " + std::to_string(limits::kNameBytes) + " bytes",
                     tree.pointer + "/name"};
    }
    for (const Finding& finding : CheckPrescription(*prescription)) {
        if (finding.severity == Severity::kError) {
            return at_root({"bad_lens", finding.message, finding.where});
        }
    }
    Result<std::shared_ptr<const Lens>> lens = Lens::Build(*prescription);
    if (!lens) return at_root(lens.error());
    return lens;
}

Result<std::shared_ptr<const Lens>> Coated(const std::shared_ptr<const Lens>& lens,
                                           const wire::Coatings& coatings) {
    if (coatings.own()) return lens;
    if (coatings.none) return lens->WithBareGlass();
    Result<std::shared_ptr<const Lens>> coated =
        lens->WithCoatings({coatings.default_name, coatings.surfaces, {}});
    if (coated) return coated;
    Error error = coated.error();
    error.where = error.where == "/default" ? coatings.default_where : "/coatings" + error.where;
    return error;
}

}  // namespace

Result<LensInState> LensAsAsked(const std::shared_ptr<const Lens>& base,
                                const wire::Coatings& coatings, const LensState& state) {
    const Result<std::shared_ptr<const Lens>> coated = Coated(base, coatings);
    if (!coated) return coated.error();
    return SetState(*coated, state);
}

Result<LensInState> LensFromWire(const wire::LensChoice& choice, const LensLibrary& library) {
    const Result<std::shared_ptr<const Lens>> base = choice.prescription
                                                         ? BuildInline(*choice.prescription)
                                                         : library.Find(choice.name.value_or(""));
    if (!base) {
        Error error = base.error();
        if (!choice.prescription) error.where = "/lens";
        return error;
    }
    Result<LensInState> lens =
        LensAsAsked(*base, choice.coatings, {choice.focus_m, choice.zoom_mm});
    if (lens || lens.error().code != "bad_lens") return lens;
    // The lens as its file has it is sound, but not in this state.
    Error error = lens.error();
    if (!choice.prescription) {
        error.where = "/lens";
    } else if (error.where.empty()) {
        error.where = choice.prescription->pointer;
    }
    return error;
}

}  // namespace flare
