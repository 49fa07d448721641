// SPDX-License-Identifier: Apache-2.0
//
// Who computed something: a hash of the running program's file and of what its mathematical library
// answers, which may round differently from machine to machine. Results that were kept under the
// same identity are equal to the last bit. Takes some milliseconds.
#pragma once

#include "core/base/fingerprint.h"

namespace flare {

Fingerprint ProgramIdentity();

}  // namespace flare
