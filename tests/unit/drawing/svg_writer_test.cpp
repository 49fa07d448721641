// SPDX-License-Identifier: Apache-2.0
#include "core/drawing/svg_writer.h"

#include <gtest/gtest.h>

#include "tests/support/xml_document.h"

namespace flare {
namespace {

using testing::XmlElement;
using testing::XmlReader;

TEST(SvgWriter, WritesNumbersWithoutWaste) {
    EXPECT_EQ(SvgWriter::Number(0.0), "0");
    EXPECT_EQ(SvgWriter::Number(-0.00001), "0");
    EXPECT_EQ(SvgWriter::Number(-1.5), "-1.5");
    EXPECT_EQ(SvgWriter::Number(100.0), "100");
    EXPECT_EQ(SvgWriter::Number(100.0, 0), "100");
    EXPECT_EQ(SvgWriter::Number(2.00004), "2");
    EXPECT_EQ(SvgWriter::Number(2.00006), "2.0001");
    EXPECT_EQ(SvgWriter::Number(1e300).size(), 301U);
    EXPECT_EQ(SvgWriter::Points({{1.0, -2.0}, {0.5, 0.25}}), "1,-2 0.5,0.25");
}

TEST(SvgWriter, GivesBackTheTextThatWentIn) {
    SvgWriter svg;
    svg.Open("g", {{"class", "a \"b\" <c> & 'd'"}});
    svg.Text("text", {}, "f/2 < f/4 & more > \xCE\xB8");
    svg.Empty("path", {{"d", "M0 0"}});
    svg.Close();
    const auto root = XmlReader::Read(svg.text());
    ASSERT_TRUE(root.has_value()) << svg.text();
    EXPECT_EQ(root->Attribute("class"), "a \"b\" <c> & 'd'");
    ASSERT_EQ(root->children.size(), 2U);
    EXPECT_EQ(root->children[0].text, "f/2 < f/4 & more > \xCE\xB8");
    EXPECT_EQ(root->children[1].Attribute("d"), "M0 0");
}

TEST(EscapedXml, LeavesNothingThatXmlCannotHold) {
    EXPECT_EQ(EscapedXml(std::string("a\0b\x1B[m\n\t", 8)), "a?b?[m\n\t");
    EXPECT_EQ(EscapedXml("x\xEF\xBF\xBEy\xEF\xBF\xBFz\xEF\xBF\xBD"), "x?y?z\xEF\xBF\xBD");
    EXPECT_EQ(EscapedXml("]]>"), "]]&gt;");
}

TEST(SvgWriterDeathTest, RefusesNumbersThatAreNone) {
    EXPECT_DEATH((void)SvgWriter::Number(0.0 / 0.0), "isfinite");
}

}  // namespace
}  // namespace flare
