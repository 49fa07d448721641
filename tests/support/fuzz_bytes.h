// SPDX-License-Identifier: Apache-2.0
//
// How many bytes of noise a decoder is fed: ten million, and a tenth of that under sanitizers,
// which take ten times as long.
#pragma once

namespace flare::test {

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FLARE_SANITIZED
#endif
#endif

#ifdef FLARE_SANITIZED
inline constexpr int kFuzzBytes = 1'000'000;
#else
inline constexpr int kFuzzBytes = 10'000'000;
#endif

}  // namespace flare::test
