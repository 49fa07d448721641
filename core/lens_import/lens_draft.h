// SPDX-License-Identifier: Apache-2.0
//
// A lens on its way from a foreign format to a prescription, and the steps that formats share.
// Private to this layer.
#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/lens_import/lens_import.h"

namespace flare {

struct LensDraft {
    // A semi-diameter of 0: the file has none, and it is worked out from pupil and field.
    Prescription lens;
    std::string title;
    std::vector<std::string> remarks;
    // The refracting surface that the file names as its stop; there a flat stop is put in.
    std::optional<std::size_t> stop_on;
    // What semi-diameters are worked out from, as far as the file says it.
    std::optional<double> pupil_mm, f_number;  // entrance pupil's diameter, or this
    std::optional<double> field_deg, image_height_mm;

    void Remark(std::string sentence) { remarks.push_back(std::move(sentence)); }
};

// What the numbers of a column of apertures are.
enum class ApertureColumn { kDiameters, kSemiDiameters };

// Halves the semi-diameters of the draft where they are diameters. `f_number` tells: the stop that
// it asks for is the paraxial one. Without it, or where the stop fits neither, `stated` is believed
// unless a rim would be wider than its sphere. What was found goes into the remarks.
void SettleApertures(LensDraft& draft, ApertureColumn stated, std::optional<double> f_number);

// Removes surfaces that refract nothing, are not the stop and have no rim of their own.
void DropDummies(LensDraft& draft);

// Multiplies all lengths.
void ScaleLengths(LensDraft& draft, double factor);

// The medium behind the last surface of the draft: named glass, or nd and vd. Air for nd = 1.
void SetMedium(SurfacePrescription& surface, double nd, std::optional<double> vd);

// The medium that a stop stands in where its row names none: that of the surface in front.
void StandInMediumInFront(SurfacePrescription& stop,
                          const std::vector<SurfacePrescription>& in_front);

// Puts in the stop, works out what is missing, and moves title and remarks to where people see
// them. Fails where glass or surfaces make that impossible, and for too many surfaces.
Result<ImportedLens> FinishDraft(LensDraft draft, LensFormat format);

// Remarks that formats share: what was passed over, by name, if anything was; that coatings could
// not be carried over.
void RemarkUnread(LensDraft& draft, const std::set<std::string>& names);
void RemarkBare(LensDraft& draft);

// "surfaces 1, 2 and 5", for remarks.
std::string SurfaceList(const std::vector<std::size_t>& surfaces);

}  // namespace flare
