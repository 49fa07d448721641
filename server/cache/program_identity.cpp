// SPDX-License-Identifier: Apache-2.0
#include "server/cache/program_identity.h"

#include <cmath>
#include <fstream>
#include <sstream>

namespace flare {
namespace {

// The C library chooses its functions by the machine's instructions, with and without fused
// multiply-adds; a few hundred arguments tell them apart.
void AddMathematics(Fingerprinter& hash) {
    constexpr int kArguments = 512;
    for (int i = 1; i <= kArguments; ++i) {
        const double x = 0.00613 * i;
        hash.Add(std::sin(x)).Add(std::cos(x)).Add(std::tan(x)).Add(std::exp(-x));
        hash.Add(std::log(x))
            .Add(std::pow(x, 1.37))
            .Add(std::atan2(x, 1.1))
            .Add(std::hypot(x, 0.3));
        hash.Add(std::asin(x / 4.0)).Add(std::acos(x / 4.0)).Add(std::cbrt(x));
    }
}

}  // namespace

Fingerprint ProgramIdentity() {
    Fingerprinter hash;
    std::ifstream program("/proc/self/exe", std::ios::binary);
    std::ostringstream bytes;
    bytes << program.rdbuf();
    hash.Add(bytes.view());
    AddMathematics(hash);
    return hash.value();
}

}  // namespace flare
