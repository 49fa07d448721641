// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace flare {

// Prints the condition and its place on stderr and aborts.
[[noreturn]] void CheckFailed(const char* condition, const char* file, int line);

}  // namespace flare

// Stops the program in every build when an invariant of ours is broken. Bad *input* is never a
// reason to check-fail: it gets a Result with an Error.
#define FLARE_CHECK(condition) \
    ((condition) ? static_cast<void>(0) : ::flare::CheckFailed(#condition, __FILE__, __LINE__))
