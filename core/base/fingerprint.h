// SPDX-License-Identifier: Apache-2.0
//
// A 128-bit hash (XXH3) of a sequence of values, the same on every machine: numbers are fed as
// little-endian bytes, strings with their length, so that no two different sequences run together.
// Not cryptographic: it names cache entries and requests, it does not protect them.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace flare {

struct Fingerprint {
    std::uint64_t high = 0;
    std::uint64_t low = 0;

    auto operator<=>(const Fingerprint&) const = default;
    std::string hex() const;  // 32 lower-case digits
};

class Fingerprinter {
  public:
    Fingerprinter();
    ~Fingerprinter();
    Fingerprinter(const Fingerprinter&) = delete;
    Fingerprinter& operator=(const Fingerprinter&) = delete;

    // -0.0 is fed as +0.0: they are one number to every caller.
    Fingerprinter& Add(double value);
    Fingerprinter& Add(std::int64_t value);
    Fingerprinter& Add(int value) { return Add(static_cast<std::int64_t>(value)); }
    Fingerprinter& Add(bool value) { return Add(static_cast<std::int64_t>(value)); }
    Fingerprinter& Add(std::string_view text);
    Fingerprinter& Add(const char* text) { return Add(std::string_view(text)); }
    Fingerprinter& Add(const Fingerprint& other);

    Fingerprint value() const;

  private:
    void AddBytes(std::uint64_t bits);
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace flare

template <>
struct std::hash<flare::Fingerprint> {
    std::size_t operator()(const flare::Fingerprint& f) const noexcept {
        return static_cast<std::size_t>(f.low);
    }
};
