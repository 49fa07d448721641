// SPDX-License-Identifier: Apache-2.0
#include "protocol/openapi.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace flare {
namespace {

TEST(OpenApiDocument, IsTheFileOfTheSourceTreeToTheLastByte) {
    std::ifstream file(FLARE_SOURCE_DIR "/protocol/openapi.yaml", std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(file)),
                           std::istreambuf_iterator<char>());
    ASSERT_GT(text.size(), 10'000u);
    EXPECT_TRUE(OpenApiDocument() == text);
}

}  // namespace
}  // namespace flare
