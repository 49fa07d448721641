// SPDX-License-Identifier: Apache-2.0
#include "server/encoder/qsb.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/fuzz_bytes.h"
#include "tests/support/random.h"

namespace flare {
namespace {

TEST(Qsb, ReadsAnswersWithAndWithoutStamp) {
    const auto plain = DecodeQsb("r0E00001234!");
    ASSERT_TRUE(plain);
    EXPECT_EQ(plain->kind, 'r');
    EXPECT_EQ(plain->register_number, kQsbCountRegister);
    EXPECT_EQ(plain->data, 0x1234u);
    EXPECT_FALSE(plain->stamp);
    const auto stamped = DecodeQsb("S0EFFFFFFFE0000ABCD");
    ASSERT_TRUE(stamped);
    EXPECT_EQ(stamped->kind, 's');
    EXPECT_EQ(stamped->data, 0xfffffffeu);
    EXPECT_EQ(stamped->stamp, 0xabcdu);
}

// The registers by the maker's list of commands, MDR0 by the data sheet of LS7366R.
TEST(Qsb, IsSetUpWithOrWithoutItsIndex) {
    EXPECT_EQ(QsbSetUp(std::nullopt), "W1505\nW0000\nW0303\nW0C0001\nR14\n");
    EXPECT_EQ(QsbSetUp(0x1234), "W1505\nW0000\nW0800001234\nW0313\nW0C0001\nR14\n");
    EXPECT_EQ(QsbSetUp(-2), "W1505\nW0000\nW08FFFFFFFE\nW0313\nW0C0001\nR14\n");
}

TEST(Qsb, RefusesWhatIsNoAnswer) {
    for (const char* line :
         {"", "!", "r", "r0E0000123", "r0E0000123G", "r0E000012345", "x0E00001234", "rxE00001234",
          "r0E00001234 000ABCD", "r0E-0001234", "r0E00001234ABCDEFGH", "r0E000012340000ABCD00"}) {
        EXPECT_FALSE(DecodeQsb(line).ok()) << line;
    }
}

TEST(Qsb, FollowsTheCounterOverItsEnds) {
    QsbCounter counter;
    EXPECT_EQ(counter.Follow(0xfffffffe), -2);
    EXPECT_EQ(counter.Follow(3), 3);
    EXPECT_EQ(counter.Follow(0x7ffffff0), 0x7ffffff0);
    EXPECT_EQ(counter.Follow(0x80000010), 0x80000010);  // past the end of 31 bits
    EXPECT_EQ(counter.Follow(0xffffffff), 0xffffffff);
    EXPECT_EQ(counter.Follow(1), 0x100000001);
    EXPECT_EQ(counter.Follow(0xffffffff), 0xffffffff);
}

TEST(Qsb, NoiseIsRefusedAndNeverHarms) {
    testing::Random random(3);
    constexpr char kAlphabet[] = "rwseRS0123456789ABCDEF!x\x80\0";
    int taken = 0;
    for (int bytes = 0; bytes < test::kFuzzBytes; bytes += 12) {
        std::string line;
        const int size = 9 + random.Below(5);
        for (int i = 0; i < size; ++i) line += kAlphabet[random.Below(sizeof kAlphabet - 1)];
        if (const auto reply = DecodeQsb(line)) {
            ++taken;
            EXPECT_LE(reply->register_number, 255);
        }
    }
    EXPECT_GT(taken, 0);
}

}  // namespace
}  // namespace flare
