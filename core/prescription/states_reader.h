// SPDX-License-Identifier: Apache-2.0
//
// Reads the [states] of a lens file: what changes with zoom and focus (lenses/FORMAT.md).
#pragma once

#include "core/base/document.h"
#include "core/base/result.h"
#include "core/optics/prescription.h"

namespace flare {

// Code "bad_lens"; whether the numbers make a lens is judged by FindStateFaults.
Result<StateTable> ReadStates(const DocumentNode& node);

}  // namespace flare
