// SPDX-License-Identifier: Apache-2.0
#include "core/base/fingerprint.h"

#include <bit>
#include <cstdio>

#include "core/base/check.h"

#define XXH_INLINE_ALL
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wshadow"
#include <xxhash.h>
#pragma GCC diagnostic pop

namespace flare {

std::string Fingerprint::hex() const {
    std::array<char, 33> text{};
    std::snprintf(text.data(), text.size(), "%016llx%016llx", static_cast<unsigned long long>(high),
                  static_cast<unsigned long long>(low));
    return text.data();
}

struct Fingerprinter::State {
    XXH3_state_t* xxh = XXH3_createState();
    State() { XXH3_128bits_reset(xxh); }
    ~State() { XXH3_freeState(xxh); }
    State(const State&) = delete;
    State& operator=(const State&) = delete;
};

Fingerprinter::Fingerprinter() : state_(std::make_unique<State>()) {}
Fingerprinter::~Fingerprinter() = default;

void Fingerprinter::AddBytes(std::uint64_t bits) {
    std::array<unsigned char, 8> bytes{};
    for (unsigned i = 0; i < 8; ++i) bytes[i] = static_cast<unsigned char>(bits >> (8U * i));
    XXH3_128bits_update(state_->xxh, bytes.data(), bytes.size());
}

Fingerprinter& Fingerprinter::Add(double value) {
    AddBytes(std::bit_cast<std::uint64_t>(value == 0.0 ? 0.0 : value));
    return *this;
}

Fingerprinter& Fingerprinter::Add(std::int64_t value) {
    AddBytes(static_cast<std::uint64_t>(value));
    return *this;
}

Fingerprinter& Fingerprinter::Add(std::string_view text) {
    AddBytes(text.size());
    XXH3_128bits_update(state_->xxh, text.data(), text.size());
    return *this;
}

Fingerprinter& Fingerprinter::Add(const Fingerprint& other) {
    AddBytes(other.high);
    AddBytes(other.low);
    return *this;
}

Fingerprint Fingerprinter::value() const {
    const XXH128_hash_t hash = XXH3_128bits_digest(state_->xxh);
    return {hash.high64, hash.low64};
}

}  // namespace flare
