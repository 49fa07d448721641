// SPDX-License-Identifier: Apache-2.0
//
// Masks as they come over the wire. The images were written by Python's zlib and struct.
#include "server/translate/mask_from_wire.h"

#include <gtest/gtest.h>

#include "core/image/mask_image.h"
#include "protocol/codec/base64.h"
#include "protocol/limits.h"

namespace flare {
namespace {

// 3 x 2, 8 bits: 255 0 51, 0 102 0.
constexpr char kGrey8[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAMAAAACCAAAAAC4HznGAAAAEElEQVR42mP4z2DMwJDGAAAIzAGZVFAwswAA"
    "AABJRU5ErkJggg==";
// 2 x 1, 16 bits: 65535 13107; and 13107 alone with a gamma of 1.
constexpr char kGrey16[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABEAAAAACB2fwVAAAADUlEQVR42mP4/9/YGAAHlwJlVZjEfAAAAABJ"
    "RU5ErkJggg==";
constexpr char kGamma[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABEAAAAABq7kcWAAAABGdBTUEAAYagMeiWXwAAAAtJREFUeNpjMDYG"
    "AACcAGe67bpyAAAAAElFTkSuQmCC";
// 9 x 1, one bit: 101100001.
constexpr char kBits[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAkAAAABAQAAAAAkubnQAAAAC0lEQVR42mPY0AAAAeMBMSDzeR4AAAAASUVO"
    "RK5CYII=";
// 2 x 1: white, a fifth opaque; red.
constexpr char kColour[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAEUlEQVR42mP4//+/8X8Ghv8AGu4FLw4Cz2IA"
    "AAAASUVORK5CYII=";
// 2 x 1 with a palette: white, black.
constexpr char kPalette[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAMAAADD/I+4AAAABlBMVEUAAAD///+l2Z/dAAAAC0lEQVR42mNg"
    "ZAAAAAUAAkLCRJ8AAAAASUVORK5CYII=";
// 2 x 4, only the upper right pixel is white.
constexpr char kTall[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAAECAAAAACBhLHlAAAADUlEQVR42mNg+M8AAwAKAgEAcUSLKwAAAABJ"
    "RU5ErkJggg==";
constexpr char kBlack[] =
    "iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAAAAABX3VL4AAAAC0lEQVR42mNgAAEAAAYAAW0oEC8AAAAASUVO"
    "RK5CYII=";
constexpr char kWide[] =  // 4096 x 1
    "iVBORw0KGgoAAAANSUhEUgAAEAAAAAABCAAAAAB7SjSgAAAAGklEQVR42u3BAQ0AAADCoPdPbQ8HFAAAAHBv"
    "EAEAAbl6AzwAAAAASUVORK5CYII=";

std::string Bytes(const char* text) {
    return wire::BytesFromBase64(text).value_or("not base64");
}

std::vector<float> Values(const char* text) {
    const Result<MaskImage> image = DecodeMaskPng(Bytes(text), limits::kMaskSide);
    EXPECT_TRUE(image) << image.error().message;
    return image ? image->values : std::vector<float>{};
}

TEST(MaskImage, ReadsEveryKindOfPngWithoutGamma) {
    EXPECT_EQ(Values(kGrey8), (std::vector<float>{1.0F, 0.0F, 0.2F, 0.0F, 0.4F, 0.0F}));
    EXPECT_EQ(Values(kGrey16), (std::vector<float>{1.0F, 0.2F}));
    EXPECT_EQ(Values(kGamma), (std::vector<float>{0.2F}));
    EXPECT_EQ(Values(kBits), (std::vector<float>{1, 0, 1, 1, 0, 0, 0, 0, 1}));
    EXPECT_EQ(Values(kPalette), (std::vector<float>{1.0F, 0.0F}));
    const std::vector<float> colour = Values(kColour);
    ASSERT_EQ(colour.size(), 2U);
    EXPECT_FLOAT_EQ(colour[0], 0.2F);
    EXPECT_NEAR(colour[1], 0.2126F, 1e-6F);
}

TEST(MaskImage, ReadsBackWhatItWrites) {
    const MaskImage mask{2, 2, {0.0F, 1.0F, 13107.0F / 65535.0F, 2.0F}};
    const Result<MaskImage> read = DecodeMaskPng(EncodeMaskPng(mask), limits::kMaskSide);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->width, 2);
    EXPECT_EQ(read->values, (std::vector<float>{0.0F, 1.0F, 0.2F, 1.0F}));
}

TEST(MaskImage, RefusesWhatIsBrokenOrTooLarge) {
    const std::string whole = Bytes(kGrey8);
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const Result<MaskImage> image = DecodeMaskPng(whole.substr(0, size), limits::kMaskSide);
        // Without the last chunk's end nothing is missing but that.
        if (image) continue;
        EXPECT_EQ(image.error().code, "bad_image") << size;
    }
    EXPECT_FALSE(DecodeMaskPng(whole.substr(0, 50), limits::kMaskSide));
    for (std::size_t at = 0; at < whole.size(); ++at) {
        std::string broken = whole;
        broken[at] = static_cast<char>(broken[at] ^ 0x55);
        const Result<MaskImage> image = DecodeMaskPng(broken, limits::kMaskSide);
        const bool refused =
            image || image.error().code == "bad_image" || image.error().code == "limit";
        EXPECT_TRUE(refused) << at;
    }
    EXPECT_EQ(DecodeMaskPng(Bytes(kWide), limits::kMaskSide).error().code, "limit");
}

// The top is up; a tall image's square reaches beyond the width that spans the stop.
TEST(MaskFromWire, StandsUprightInTheMiddleOfASquare) {
    const auto tall = MaskFromWire({Bytes(kTall), wire::IrisMaskScale::kStop});
    ASSERT_TRUE(tall);
    EXPECT_EQ((*tall)->half_width_mm(), 2.0);
    EXPECT_EQ((*tall)->At({0.5, 1.5}), 1.0);
    EXPECT_EQ((*tall)->At({-0.5, 1.5}), 0.0);
    EXPECT_EQ((*tall)->At({0.5, -1.5}), 0.0);
    EXPECT_EQ((*tall)->area_mm2(), 1.0);
}

TEST(MaskFromWire, SaysWhereABadMaskStands) {
    const auto black = MaskFromWire({Bytes(kBlack), wire::IrisMaskScale::kArea});
    ASSERT_FALSE(black);
    EXPECT_EQ(black.error().code, "bad_value");
    EXPECT_EQ(black.error().where, "/iris/mask/png_base64");
    const auto text = MaskFromWire({"no image", wire::IrisMaskScale::kArea});
    ASSERT_FALSE(text);
    EXPECT_EQ(text.error().code, "bad_image");
    EXPECT_EQ(text.error().where, "/iris/mask/png_base64");
}

TEST(Base64, GoesThereAndBackAndTakesOneFormOnly) {
    // RFC 4648, section 10.
    const std::pair<const char*, const char*> samples[] = {{"", ""},
                                                           {"f", "Zg=="},
                                                           {"fo", "Zm8="},
                                                           {"foo", "Zm9v"},
                                                           {"foob", "Zm9vYg=="},
                                                           {"fooba", "Zm9vYmE="},
                                                           {"foobar", "Zm9vYmFy"}};
    for (const auto& [bytes, text] : samples) {
        EXPECT_EQ(wire::Base64(bytes), text);
        EXPECT_EQ(wire::BytesFromBase64(text), bytes);
    }
    for (const char* bad : {"Z", "Zg=", "Zg", "Zh==", "Zm9=", "Z===", "====", "Zg==Zg==", "Zm9v\n"})
        EXPECT_FALSE(wire::BytesFromBase64(bad)) << bad;
}

}  // namespace
}  // namespace flare
