// SPDX-License-Identifier: Apache-2.0
#include "core/base/fingerprint.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

namespace flare {
namespace {

TEST(Fingerprint, OfNothingIsXxh3sOwn) {
    // The published digest of the empty input.
    EXPECT_EQ(Fingerprinter().value().hex(), "99aa06d3014798d86001c324468d497f");
}

TEST(Fingerprint, IsTheSameForTheSameSequence) {
    const auto make = [] { return Fingerprinter().Add(1.5).Add(7).Add("lens").Add(true).value(); };
    EXPECT_EQ(make(), make());
    EXPECT_EQ(make().hex().size(), 32U);
    // value() does not end the sequence.
    Fingerprinter growing;
    growing.Add(1);
    const Fingerprint first = growing.value();
    EXPECT_EQ(growing.value(), first);
    EXPECT_NE(growing.Add(2).value(), first);
}

TEST(Fingerprint, TellsSequencesApartThatRunTogetherAsText) {
    std::set<std::string> seen;
    std::vector<Fingerprint> all;
    all.push_back(Fingerprinter().Add("ab").Add("c").value());
    all.push_back(Fingerprinter().Add("a").Add("bc").value());
    all.push_back(Fingerprinter().Add("abc").value());
    all.push_back(Fingerprinter().Add("").Add("abc").value());
    all.push_back(Fingerprinter().Add("abc").Add("").value());
    all.push_back(Fingerprinter().Add(1).Add(2).value());
    all.push_back(Fingerprinter().Add(2).Add(1).value());
    all.push_back(Fingerprinter().Add(12).value());
    all.push_back(Fingerprinter().Add(1.0).value());
    all.push_back(Fingerprinter().Add(1).value());
    all.push_back(Fingerprinter().Add(std::string_view("\0", 1)).value());
    all.push_back(Fingerprinter().Add(std::string_view("\0\0", 2)).value());
    for (const Fingerprint& f : all) seen.insert(f.hex());
    EXPECT_EQ(seen.size(), all.size());
}

TEST(Fingerprint, TakesMinusZeroForZeroAndNoOtherNumbersForEachOther) {
    EXPECT_EQ(Fingerprinter().Add(-0.0).value(), Fingerprinter().Add(0.0).value());
    EXPECT_NE(Fingerprinter().Add(1.0).value(), Fingerprinter().Add(-1.0).value());
    EXPECT_NE(Fingerprinter().Add(1.0).value(), Fingerprinter().Add(1.0 + 1e-15).value());
    EXPECT_NE(Fingerprinter().Add(5e-324).value(), Fingerprinter().Add(0.0).value());
}

TEST(Fingerprint, OfAFingerprintDependsOnIt) {
    const Fingerprint a = Fingerprinter().Add(1).value(), b = Fingerprinter().Add(2).value();
    EXPECT_NE(Fingerprinter().Add(a).value(), Fingerprinter().Add(b).value());
    EXPECT_NE(Fingerprinter().Add(a).value(), a);
    EXPECT_NE(std::hash<Fingerprint>()(a), std::hash<Fingerprint>()(b));
}

TEST(Fingerprint, KeepsTenThousandNeighboursApart) {
    std::set<Fingerprint> seen;
    for (int i = 0; i < 10'000; ++i) seen.insert(Fingerprinter().Add(0.1 * i).value());
    EXPECT_EQ(seen.size(), 10'000U);
}

}  // namespace
}  // namespace flare
