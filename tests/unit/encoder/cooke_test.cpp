// SPDX-License-Identifier: Apache-2.0
//
// The published examples of the Cooke /i user's guide and technical manual 3.0 (2012), 5.1.1 to
// 5.1.11.
#include "server/encoder/cooke.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/fuzz_bytes.h"
#include "tests/support/random.h"

namespace flare {
namespace {

constexpr char kText[] =
    "D0000402T0195t1.4+8Z0000H0087250N0000400F0000404V006.8E+039z0000S5/100-009";
// The same lens a little later, in both forms: 1021 mm or tenths of an inch at T1.95.
constexpr char kLater[] =
    "D0001021T0195t1.4+8Z0000H0290024N0001018F0001024V006.8E+098z0000S5/100-009";
constexpr char kLaterPacked[] = "d@@O}CC\x8e\x88@@AFsh@@Oz@@P@ADA\xa2@@S5/100-009";
constexpr char kFixed[] = "NS5/100-009OCooke Optics Electronic Lenses!LPF100N100UBt92  B5.03";

std::string Sum(std::string_view text) {
    const auto sum = CookeChecksum(text);
    return {sum[0], sum[1]};
}

TEST(Cooke, ChecksumsAreThoseOfTheManual) {
    EXPECT_EQ(Sum("B 5.03"), "HE");
    EXPECT_EQ(Sum("!"), "MN");
    const auto text = CheckCookeChecksum("B 5.03HE");
    ASSERT_TRUE(text);
    EXPECT_EQ(*text, "B 5.03");
    EXPECT_FALSE(CheckCookeChecksum("B 5.04HE").ok());
    EXPECT_FALSE(CheckCookeChecksum("H").ok());
}

TEST(Cooke, ReadsTheFixedData) {
    const auto lens = DecodeCookeLens(kFixed);
    ASSERT_TRUE(lens) << lens.error().message;
    EXPECT_EQ(lens->serial, "5/100-009");
    EXPECT_EQ(lens->owner, "Cooke Optics Electronic Lenses!");
    EXPECT_FALSE(lens->zoom);
    EXPECT_EQ(lens->focal_mm, 100);
    EXPECT_EQ(lens->longest_focal_mm, 100);
    EXPECT_TRUE(lens->imperial);
    std::string zoom = kFixed;
    zoom.replace(zoom.find("LPF100N100UB"), 12, "LZN015M040UM");
    const auto other = DecodeCookeLens(zoom);
    ASSERT_TRUE(other);
    EXPECT_TRUE(other->zoom);
    EXPECT_EQ(other->focal_mm, 15);
    EXPECT_EQ(other->longest_focal_mm, 40);
    EXPECT_FALSE(other->imperial);
}

TEST(Cooke, ReadsTheTextRecord) {
    const auto record = DecodeCookeText(kText);
    ASSERT_TRUE(record) << record.error().message;
    EXPECT_EQ(record->focus, 402.0);
    EXPECT_EQ(record->t_stop, 1.95);
    EXPECT_EQ(record->zoom_mm, 0);
    EXPECT_EQ(record->serial, "5/100-009");
    EXPECT_NEAR(CookeFocus_m(*record, true), 1.02108, 1e-9);  // 40.2 inches
    EXPECT_EQ(CookeFocus_m(*record, false), 0.402);
}

TEST(Cooke, ReadsThePackedRecordAsTheTextOfTheSameMoment) {
    const auto packed = DecodeCookePacked(kLaterPacked), text = DecodeCookeText(kLater);
    ASSERT_TRUE(packed) << packed.error().message;
    ASSERT_TRUE(text);
    EXPECT_EQ(packed->focus, text->focus);
    EXPECT_EQ(packed->focus, 1021.0);
    EXPECT_EQ(packed->t_stop, text->t_stop);
    EXPECT_EQ(packed->zoom_mm, text->zoom_mm);
    EXPECT_EQ(packed->serial, text->serial);
}

TEST(Cooke, KnowsInfinityAndZooms) {
    std::string packed = kLaterPacked;
    packed.replace(1, 4, "\x7f\x7f\x7f\x7f");
    packed.replace(9, 2, "@e");
    const auto record = DecodeCookePacked(packed);
    ASSERT_TRUE(record);
    EXPECT_TRUE(std::isinf(record->focus));
    EXPECT_EQ(record->zoom_mm, 37);
    EXPECT_TRUE(std::isinf(CookeFocus_m(*record, true)));
}

TEST(Cooke, TakesTheRecordsOfOlderLenses) {
    std::string text = kText;
    text.erase(text.find("z0000"), 5);
    EXPECT_TRUE(DecodeCookeText(text));
    std::string packed = kLaterPacked;
    packed.erase(packed.find("@@S5"), 2);
    EXPECT_TRUE(DecodeCookePacked(packed));
}

TEST(Cooke, RefusesRecordsThatWereCutOrBent) {
    for (std::size_t size = 0; size < 59; ++size) {
        EXPECT_FALSE(DecodeCookeText(std::string_view(kText).substr(0, size)).ok()) << size;
    }
    for (std::size_t size = 0; size < 27; ++size) {
        EXPECT_FALSE(DecodeCookePacked(std::string_view(kLaterPacked).substr(0, size)).ok())
            << size;
    }
    for (std::size_t size = 0; size < 55; ++size) {
        EXPECT_FALSE(DecodeCookeLens(std::string_view(kFixed).substr(0, size)).ok()) << size;
    }
    std::string bent = kText;
    bent[3] = 'x';
    EXPECT_FALSE(DecodeCookeText(bent).ok());
    bent = kLaterPacked;
    bent[2] = '!';
    EXPECT_FALSE(DecodeCookePacked(bent).ok());
    bent = kLaterPacked;
    bent.replace(5, 2, "@@");
    EXPECT_FALSE(DecodeCookePacked(bent).ok()) << "T0";
}

TEST(Cooke, NoiseNeverHarms) {
    testing::Random random(5);
    int taken = 0;
    for (int bytes = 0; bytes < test::kFuzzBytes;) {
        for (std::string line : {kText, kLaterPacked, kFixed}) {
            bytes += static_cast<int>(line.size());
            for (int changes = random.Below(4); changes > 0; --changes) {
                const auto at =
                    static_cast<std::size_t>(random.Below(static_cast<int>(line.size())));
                line[at] = static_cast<char>(random.Below(256));
            }
            line.resize(line.size() - static_cast<std::size_t>(random.Below(2) * random.Below(9)));
            if (const auto record = DecodeCookeText(line)) {
                ++taken;
                EXPECT_GT(record->t_stop, 0.0);
            }
            if (const auto record = DecodeCookePacked(line)) {
                ++taken;
                EXPECT_GT(record->t_stop, 0.0);
                EXPECT_GE(record->focus, 0.0);
            }
            if (DecodeCookeLens(line)) ++taken;
        }
    }
    EXPECT_GT(taken, 1'000);
}

}  // namespace
}  // namespace flare
