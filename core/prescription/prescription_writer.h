// SPDX-License-Identifier: Apache-2.0
//
// Writes a prescription as the text of a lens file (lenses/FORMAT.md). Numbers have as many digits
// as it takes to read the same ones back, so that a prescription survives the way out and in again
// but for its places and the comments of the file it came from.
#pragma once

#include <string>

#include "core/optics/prescription.h"

namespace flare {

// Requires finite numbers where the format wants numbers; the default of a key is left out.
std::string TomlFromPrescription(const Prescription& prescription);

}  // namespace flare
