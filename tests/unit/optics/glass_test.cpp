// SPDX-License-Identifier: Apache-2.0
#include "core/optics/glass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/base/fingerprint.h"

namespace flare {
namespace {

using Formula = GlassData::Formula;

// The Sellmeier constants of SCHOTT N-BK7 as its data sheet has them.
GlassData Bk7() {
    GlassData data;
    data.terms = {
        {1.03961212, 0.00600069867}, {0.231792344, 0.0200179144}, {1.01046945, 103.560653}};
    data.low_nm = 300.0;
    data.high_nm = 2500.0;
    return data;
}

Fingerprint DispersionOf(const Glass& glass) {
    Fingerprinter fingerprinter;
    glass.AddDispersionTo(fingerprinter);
    return fingerprinter.value();
}

Fingerprint AbsorptionOf(const Glass& glass) {
    Fingerprinter fingerprinter;
    glass.AddAbsorptionTo(fingerprinter);
    return fingerprinter.value();
}

TEST(Glass, CauchyIsExactAtDAndInItsVNumber) {
    const Glass glass = Glass::FromNdVd(1.5168, 64.17);
    EXPECT_NEAR(glass.nd(), 1.5168, 1e-15);
    EXPECT_NEAR(glass.vd(), 64.17, 1e-10);
    EXPECT_FALSE(glass.absorbs());
    EXPECT_EQ(glass.AbsorptionPerMm(400.0), 0.0);
    EXPECT_TRUE(Glass::Air().is_air());
    EXPECT_TRUE(Glass::FromNdVd(1.0, 50.0).is_air());
    EXPECT_EQ(Glass::FromNdVd(1.7, std::nullopt).Index(400.0), 1.7);
}

// The header's claim on how good two terms are.
TEST(Glass, CauchyIsWithinItsBoundsOfTheSellmeierFormula) {
    const Glass sellmeier(Bk7());
    const Glass cauchy = Glass::FromNdVd(1.5168, 64.17);
    for (int nm = 400; nm <= 706; ++nm) {
        EXPECT_NEAR(cauchy.Index(nm), sellmeier.Index(nm), 1.5e-4) << nm;
    }
    EXPECT_NEAR(cauchy.Index(1014.0) - sellmeier.Index(1014.0), 1.4e-3, 1e-4);
}

// At 500 nm (l^2 = 0.25 um^2) the sums can be done by hand.
TEST(Glass, EachFormulaGivesItsValueByHand) {
    GlassData data;
    data.low_nm = 300.0;
    data.high_nm = 1000.0;
    data.constant = 1.25;
    data.terms = {{0.5, 0.05}, {3.0, 1.0}};  // 0.5 0.25/0.2 = 0.625; 3 0.25/-0.75 = -1
    EXPECT_NEAR(Glass(data).Index(500.0), std::sqrt(0.875), 1e-15);
    data.formula = Formula::kSquaredPowers;
    data.terms = {{2.0, 2.0}, {0.03125, -4.0}};  // 0.5; 0.03125 16 = 0.5
    EXPECT_NEAR(Glass(data).Index(500.0), 1.5, 1e-15);
    data.formula = Formula::kPowers;
    EXPECT_NEAR(Glass(data).Index(500.0), 2.25, 1e-15);
}

TEST(Glass, BeyondItsRangeTheIndexIsThatOfTheNearerEnd) {
    const Glass glass(Bk7());
    // The pole of the second term lies at 141 nm.
    EXPECT_EQ(glass.Index(std::sqrt(0.0200179144) * 1000.0), glass.Index(300.0));
    EXPECT_EQ(glass.Index(0.0), glass.Index(300.0));
    EXPECT_EQ(glass.Index(1e6), glass.Index(2500.0));
    EXPECT_NE(glass.Index(301.0), glass.Index(300.0));
    const Glass cauchy = Glass::FromNdVd(1.7, 30.0);
    EXPECT_EQ(cauchy.Index(0.0), cauchy.Index(300.0));
    EXPECT_EQ(cauchy.Index(5000.0), cauchy.Index(1100.0));
}

TEST(Glass, AbsorptionRunsThroughItsPointsAndHoldsBeyondThem) {
    GlassData data = Bk7();
    data.absorption = {{400.0, 1e-6}, {500.0, 1e-8}, {600.0, 0.0}, {700.0, 2e-8}};
    const Glass glass(std::move(data));
    const auto k = [&](double nm) { return glass.AbsorptionPerMm(nm) * nm * 1e-6 / (4.0 * M_PI); };
    EXPECT_TRUE(glass.absorbs());
    EXPECT_NEAR(k(400.0), 1e-6, 1e-18);
    EXPECT_NEAR(k(500.0), 1e-8, 1e-20);
    EXPECT_EQ(k(600.0), 0.0);
    // 444.44 nm is half way from 400 to 500 in 1 / lambda: the geometric mean.
    EXPECT_NEAR(k(2.0 / (1.0 / 400.0 + 1.0 / 500.0)), 1e-7, 1e-19);
    // 646.15 nm is half way from 600 to 700, and where one end is 0 the mean is the arithmetic one.
    EXPECT_NEAR(k(2.0 / (1.0 / 600.0 + 1.0 / 700.0)), 1e-8, 1e-20);
    EXPECT_NEAR(k(350.0), 1e-6, 1e-18);
    EXPECT_NEAR(k(900.0), 2e-8, 1e-20);
}

TEST(Glass, EqualityAndFingerprintsFollowTheNumbers) {
    const Glass glass(Bk7());
    EXPECT_TRUE(glass == Glass(Bk7()));
    EXPECT_FALSE(glass == Glass::FromNdVd(glass.nd(), glass.vd()));
    EXPECT_FALSE(glass == Glass::Air());
    EXPECT_NE(DispersionOf(glass), DispersionOf(Glass::Air()));
    EXPECT_NE(DispersionOf(Glass::FromNdVd(1.7, 30.0)), DispersionOf(Glass::FromNdVd(1.7, 31.0)));

    const auto changed = [](auto change) {
        GlassData data = Bk7();
        change(data);
        return Glass(std::move(data));
    };
    for (const Glass& other : {changed([](GlassData& d) { d.constant += 1e-9; }),
                               changed([](GlassData& d) { d.terms[1].place += 1e-9; }),
                               changed([](GlassData& d) { d.terms.pop_back(); }),
                               changed([](GlassData& d) { d.formula = Formula::kPowers; }),
                               changed([](GlassData& d) { d.high_nm = 2400.0; })}) {
        EXPECT_FALSE(other == glass);
        EXPECT_NE(DispersionOf(other), DispersionOf(glass));
        EXPECT_EQ(AbsorptionOf(other), AbsorptionOf(glass));
    }
    const Glass dim = changed([](GlassData& d) { d.absorption = {{400.0, 1e-7}}; });
    EXPECT_FALSE(dim == glass);
    EXPECT_EQ(DispersionOf(dim), DispersionOf(glass)) << "absorption bends no rays";
    EXPECT_NE(AbsorptionOf(dim), AbsorptionOf(glass));
}

}  // namespace
}  // namespace flare
