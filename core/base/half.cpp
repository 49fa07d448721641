// SPDX-License-Identifier: Apache-2.0
//
// The portable loop works on the bits of the magnitude and has no branch, so that compilers make
// vectors of it: normal and subnormal halves are both computed and one is chosen by a mask.
#include "core/base/half.h"

#include <algorithm>
#include <bit>

#if defined(__x86_64__)
#include <cpuid.h>
#include <immintrin.h>
#endif

namespace flare {
namespace {

// Bits of float magnitudes.
constexpr std::int32_t kLargestBits = std::bit_cast<std::int32_t>(kLargestHalf);
constexpr std::int32_t kInfinityBits = 0x7f800000;
constexpr std::int32_t kSmallestNormalBits = std::bit_cast<std::int32_t>(0x1p-14f);

// All bits set where the condition holds.
inline std::int32_t Mask(bool condition) {
    return -static_cast<std::int32_t>(condition);
}

inline std::int32_t HalfOfMagnitude(std::int32_t magnitude) {
    const std::int32_t held = std::min(magnitude, kLargestBits);
    // Exponent bias 127 becomes 15, 23 bits of mantissa become 10.
    const std::int32_t normal = (held - ((127 - 15) << 23) + 0xfff + ((held >> 13) & 1)) >> 13;
    // A unit in the last place of 0.5 is 2^-24, the same as that of a subnormal half: the addition
    // rounds, and leaves the half in the sum's mantissa.
    const std::int32_t subnormal = std::bit_cast<std::int32_t>(std::bit_cast<float>(held) + 0.5f) -
                                   std::bit_cast<std::int32_t>(0.5f);
    const std::int32_t quiet_nan = 0x7e00 | ((magnitude >> 13) & 0x3ff);
    const std::int32_t is_subnormal = Mask(held < kSmallestNormalBits);
    const std::int32_t is_nan = Mask(magnitude > kInfinityBits);
    const std::int32_t number = (subnormal & is_subnormal) | (normal & ~is_subnormal);
    return (number & ~is_nan) | (quiet_nan & is_nan);
}

#if defined(__x86_64__)
__attribute__((target("avx,f16c"))) bool ConvertByF16c(const float* values, std::size_t count,
                                                       std::uint16_t* halves) {
    const __m256 largest = _mm256_set1_ps(kLargestHalf);
    const __m256 smallest = _mm256_set1_ps(-kLargestHalf);
    __m256 changed = _mm256_setzero_ps();
    std::size_t i = 0;
    for (; i + 8 <= count; i += 8) {
        const __m256 value = _mm256_loadu_ps(values + i);
        // Of a NaN and a number, min and max give their second operand.
        const __m256 held = _mm256_max_ps(smallest, _mm256_min_ps(largest, value));
        changed = _mm256_or_ps(changed, _mm256_cmp_ps(held, value, _CMP_NEQ_OQ));
        _mm_storeu_si128(reinterpret_cast<__m128i*>(halves + i),
                         _mm256_cvtps_ph(held, _MM_FROUND_TO_NEAREST_INT));
    }
    const bool saturated = _mm256_movemask_ps(changed) != 0;
    return ConvertToHalfPortably(values + i, count - i, halves + i) || saturated;
}

bool HasF16c() {
    unsigned a = 0, b = 0, c = 0, d = 0;
    // The system, too, must know of the wide registers: "avx" says so.
    return __builtin_cpu_supports("avx") && __get_cpuid(1, &a, &b, &c, &d) && (c & bit_F16C) != 0;
}
#endif

}  // namespace

bool ConvertToHalfPortably(const float* values, std::size_t count, std::uint16_t* halves) {
    std::int32_t largest = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const auto bits = std::bit_cast<std::int32_t>(values[i]);
        const std::int32_t magnitude = bits & 0x7fffffff;
        largest = std::max(largest, magnitude & ~Mask(magnitude > kInfinityBits));
        halves[i] = static_cast<std::uint16_t>(HalfOfMagnitude(magnitude) | (bits >> 16 & 0x8000));
    }
    return largest > kLargestBits;
}

bool ConvertToHalf(const float* values, std::size_t count, std::uint16_t* halves) {
#if defined(__x86_64__)
    static const bool f16c = HasF16c();
    if (f16c) return ConvertByF16c(values, count, halves);
#endif
    return ConvertToHalfPortably(values, count, halves);
}

}  // namespace flare
