#include "tread/io/text_tree.hpp"

#include <gtest/gtest.h>

namespace tread::internal {
namespace {

#define EXPECT_SAYS(message, part) \
  EXPECT_NE((message).find(part), std::string::npos) << "says: " << (message)

std::string yaml_error(const std::string& text) {
  const auto tree = parse_yaml(text, "f");
  EXPECT_FALSE(tree);
  return tree ? "" : tree.error().message();
}

std::string xml_error(const std::string& text) {
  const auto tree = parse_xml(text, "f");
  EXPECT_FALSE(tree);
  return tree ? "" : tree.error().message();
}

TEST(TextTree, YamlValuesAndLines) {
  const auto tree = parse_yaml("a: 1\nb:\n  c: [1, 2]\n  d: text\nn:\n", "f");
  ASSERT_TRUE(tree);
  const Field root(*tree, "f");
  EXPECT_EQ(root.at("a")->number().value(), 1.0);
  const Field b = root.at("b").value();
  EXPECT_EQ(b.at("c")->numbers().value(), (std::vector<double>{1, 2}));
  EXPECT_EQ(b.at("d")->text().value(), "text");
  EXPECT_EQ(b.at("d")->where(), "f:4: b.d");
  EXPECT_SAYS(b.at("x").error().message(), "f:3: b: 'x' is missing");
  EXPECT_SAYS(root.at("n")->number().error().message(), "n: expected a number");
  EXPECT_SAYS(root.at("a")->at("x").error().message(), "expected entries, with 'x' among them");
  EXPECT_SAYS(root.at("a")->allow_only({"x"}).error().message(), "expected entries");
  EXPECT_SAYS(root.at("a")->truth().error().message(), "expected true or false");
}

TEST(TextTree, NumbersAreFiniteAndWhole) {
  EXPECT_EQ(parse_finite("1."), 1.0);
  EXPECT_EQ(parse_finite("+2.5e-1"), 0.25);
  for (const char* text : {"", "1x", "nan", "inf", "1e999", "0x10", " 1", "+-1", "1,5"}) {
    EXPECT_FALSE(parse_finite(text)) << text;
  }
}

TEST(TextTree, OpenCvHeaderIsBlankedOutWithoutMovingLines) {
  for (const char* header :
       {"%YAML:1.0\n---\n", "\xEF\xBB\xBF%YAML:1.0\r\n---\n", "\n%YAML:1.0\n"}) {
    const auto tree = parse_yaml(std::string(header) + "a: 1\n", "f");
    ASSERT_TRUE(tree) << tree.error().message();
    EXPECT_EQ(Field(*tree, "f").at("a")->where(), "f:3: a");
  }
}

TEST(TextTree, YamlSyntaxErrorsNameTheLine) {
  EXPECT_SAYS(yaml_error("a: 1\nb: [1, 2\n"), "f:3: not YAML");
  EXPECT_SAYS(yaml_error("a: 1\n  b: 2\n"), "f:2: not YAML");
  EXPECT_SAYS(yaml_error("a: 1\nb: 2\na: 3\n"), ":3: a: the name is there twice");
  EXPECT_SAYS(yaml_error("[1, 2]: 3\n"), "a name is not a text");
  EXPECT_SAYS(yaml_error("a: *nowhere\n"), "not YAML");
}

TEST(TextTree, EndlessTreesAreRefused) {
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string last = "*a" + std::to_string(i - 1);
    bomb += "a" + std::to_string(i) + ": &a" + std::to_string(i) + " [";
    for (int k = 0; k < 9; ++k) bomb += last + ", ";
    bomb += last + "]\n";
  }
  EXPECT_SAYS(yaml_error(bomb), "beyond any calibration file");
  EXPECT_SAYS(yaml_error(std::string(40, '[') + std::string(40, ']')), "beyond any calibration");
  EXPECT_SAYS(yaml_error("a: &a [*a]\n"), "f");
  EXPECT_FALSE(yaml_error(std::string(100000, '[')).empty());
  std::string deep, wide;
  for (int i = 0; i < 40; ++i) deep += "<a>";
  EXPECT_SAYS(xml_error(deep), "beyond any calibration file");
  for (int i = 0; i < 30000; ++i) wide += "<_/>";
  EXPECT_SAYS(xml_error("<r>" + wide + "</r>"), "beyond any calibration file");
}

TEST(TextTree, XmlValuesAndLines) {
  const auto tree = parse_xml(
      "\xEF\xBB\xBF<?xml version=\"1.0\"?>\n<!-- x -->\n<root>\n<a k=\"v\">1 2\n 3</a>\n"
      "<b><!-- <c> --><d>\"quoted text\"</d></b><e/><f></f>\n<l><_>1</_><_>2 3</_></l>\n</root>",
      "f");
  ASSERT_TRUE(tree) << tree.error().message();
  const Field root(*tree, "f");
  EXPECT_EQ(root.at("a")->numbers(3).value(), (std::vector<double>{1, 2, 3}));
  EXPECT_EQ(root.at("a")->where(), "f:4: a");
  EXPECT_EQ(root.at("b")->at("d")->text().value(), "quoted text");
  EXPECT_EQ(root.at("l")->numbers().value(), (std::vector<double>{1, 2, 3}));
  EXPECT_SAYS(root.at("e")->number().error().message(), "e: expected a number");
  EXPECT_SAYS(root.at("f")->text().error().message(), "f: expected a text");
}

TEST(TextTree, XmlSyntaxErrorsNameTheLine) {
  EXPECT_SAYS(xml_error(""), "f:1: not XML: a tag is missing");
  EXPECT_SAYS(xml_error("<a>\n\n"), "f:1: not XML: a tag is missing");
  EXPECT_SAYS(xml_error("<a>\n<b"), "f:2: not XML: a tag does not end");
  EXPECT_SAYS(xml_error("<a>\n</b>"), "f:2: not XML: '</a>' is missing");
  EXPECT_SAYS(xml_error("<a><b>1</b><b>2</b></a>"), "'b' is there twice");
  EXPECT_SAYS(xml_error("<!-- a"), "a comment does not end");
  EXPECT_SAYS(xml_error("<?xml"), "a comment does not end");
  EXPECT_SAYS(xml_error("<!DOCTYPE a [<!ENTITY b \"c\">]><a/>"), "is not the start of an element");
  EXPECT_SAYS(xml_error("<>"), "is not the start of an element");
}

}  // namespace
}  // namespace tread::internal
