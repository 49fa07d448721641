// SPDX-License-Identifier: Apache-2.0
#include "server/negotiation.h"

#include <gtest/gtest.h>

namespace flare {
namespace {

TEST(Accept, PicksTheFormTheClientPrefers) {
    const struct {
        const char* accept;
        std::optional<ReplyFormat> format;
    } kRows[] = {
        {"", ReplyFormat::kExr},
        {"*/*", ReplyFormat::kExr},
        {"image/*", ReplyFormat::kExr},
        {"image/png", ReplyFormat::kPng},
        {"IMAGE/PNG", ReplyFormat::kPng},
        {"application/*", ReplyFormat::kHalfPlanes},
        {"application/x-flare-half", ReplyFormat::kHalfPlanes},
        {"image/x-exr;q=0.5, image/png", ReplyFormat::kPng},
        {"image/x-exr;q=0.5, image/png;q=0.4", ReplyFormat::kExr},
        {"image/png;q=0.8, */*;q=0.9", ReplyFormat::kExr},
        {"image/x-exr;q=0, */*", ReplyFormat::kPng},
        {"image/x-exr ; q=0 , image/png ; q=0, */*", ReplyFormat::kHalfPlanes},
        {"text/html, image/png", ReplyFormat::kPng},
        {"text/html", std::nullopt},
        {"*/*;q=0", std::nullopt},
        {"image/png;q=bad", std::nullopt},
        {"image", std::nullopt},
        {"application/json", std::nullopt},
    };
    for (const auto& row : kRows) EXPECT_EQ(FormatForAccept(row.accept), row.format) << row.accept;
    EXPECT_EQ(FormatForAccept(std::nullopt), ReplyFormat::kExr);
}

TEST(ContentType, IsJsonOrAbsent) {
    for (const char* good :
         {"application/json", "Application/JSON", "application/json; charset=utf-8",
          "application/json;charset=\"UTF-8\""}) {
        EXPECT_TRUE(IsJson(good)) << good;
    }
    for (const char* bad : {"text/plain", "application/x-www-form-urlencoded", "", "json",
                            "application/jsonx", "application/json; charset=latin1"}) {
        EXPECT_FALSE(IsJson(bad)) << bad;
    }
    EXPECT_TRUE(IsJson(std::nullopt));
}

}  // namespace
}  // namespace flare
