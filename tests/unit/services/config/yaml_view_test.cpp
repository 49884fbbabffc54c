// Words, numbers, durations and the access to a YAML tree.

#include "services/config/yaml_view.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "services/config/text.hpp"
#include "services/config/yaml_tree.hpp"

namespace hecaton::config {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(TextTest, NearestWordHasTheFewestEdits) {
  constexpr std::array<std::string_view, 3> kWords = {"damper", "follower", "start"};
  EXPECT_EQ(nearest_word("dampr", kWords), "damper");
  EXPECT_EQ(nearest_word("flower", kWords), "follower");
  EXPECT_EQ(nearest_word("strat", kWords), "start");
}

TEST(TextTest, AlternativesFormASentence) {
  constexpr std::array<std::string_view, 3> kWords = {"a", "b", "c"};
  EXPECT_EQ(alternatives(kWords), "a, b or c");
  EXPECT_EQ(alternatives(std::span(kWords).first(1)), "a");
  EXPECT_EQ(alternatives({}), "");
}

TEST(TextTest, PrintableKeepsOneLineAndWholeCharacters) {
  EXPECT_EQ(printable("a\nb\x01"), "a\\x0ab\\x01");
  // 79 letters, then a character of two bytes, of which only one fits: it is left out whole.
  const std::string letters(79, 'a');
  EXPECT_EQ(printable(letters + "é" + "tail"), letters + "…");
}

TEST(TextTest, PrintableKeepsLongPathsWhole) {
  const std::string path = "/home/" + std::string(300, 'd') + "/arm.so";
  EXPECT_EQ(printable_path(path), path);
  EXPECT_EQ(printable_path("a\n" + path), "a\\x0a" + path);
  EXPECT_EQ(printable_path(std::string(1000, 'd')), std::string(400, 'd') + "…");
}

TEST(TextTest, PrintableEscapesBytesThatAreNoUtf8) {
  EXPECT_EQ(printable("a\xff\xc3z"), "a\\xff\\xc3z");
  EXPECT_EQ(valid_utf8("line\n\xe2\x82"), "line\n\\xe2\\x82");
  EXPECT_EQ(valid_utf8("“µ”\n"), "“µ”\n");
}

TEST(TextTest, SentenceShowsNoFileContents) {
  EXPECT_EQ(sentence_text("cell.yaml: arm 'a\x01': µ"), "cell.yaml: arm 'a\\x01': µ");
  const std::string word(100'000, 'x');
  EXPECT_EQ(sentence_text("a " + word + " b"), "a " + word.substr(0, 200) + "… b");
  std::string words;
  for (int i = 0; i < 100'000; ++i) words += "x ";
  EXPECT_LT(sentence_text(words).size(), 3100U);
}

TEST(NumberTest, ParsesOneDecimalNumber) {
  EXPECT_EQ(parse_number("1"), 1.0);
  EXPECT_EQ(parse_number("+2.5"), 2.5);
  EXPECT_EQ(parse_number("-1e-3"), -0.001);
  EXPECT_EQ(parse_number(".5"), 0.5);
  EXPECT_EQ(parse_number("1e999"), kInfinity);
  EXPECT_EQ(parse_number("1e-999"), 0.0);
  EXPECT_EQ(parse_number("-.inf"), -kInfinity);
  EXPECT_TRUE(std::isnan(parse_number(".NaN").value_or(0.0)));
  for (const std::string_view text : {"", "+", "+-1", "1 ", "1,5", "0x10", "1e", "one", "--1"}) {
    EXPECT_FALSE(parse_number(text).has_value()) << text;
  }
}

TEST(DurationTest, ParsesNumberAndUnit) {
  EXPECT_EQ(parse_duration("20ms"), 0.020);
  EXPECT_EQ(parse_duration("1.5 s"), 1.5);
  EXPECT_EQ(parse_duration("250us"), 0.00025);
  EXPECT_EQ(parse_duration("250µs"), 0.00025);
  EXPECT_EQ(parse_duration("8ns"), 8e-9);
  EXPECT_DOUBLE_EQ(parse_duration("2min").value_or(0.0), 120.0);
  EXPECT_EQ(parse_duration("-1s"), -1.0);
  for (const std::string_view text : {"", "20", "ms", "20 m", "20h", "s20", "1.5.2s", "20\tms"}) {
    EXPECT_FALSE(parse_duration(text).has_value()) << text;
  }
}

TEST(YamlTreeTest, CopiesAliases) {
  const YamlNode root = read_yaml_text("a: &x {k: 1}\nb: *x\n", "f.yaml");
  ASSERT_EQ(root.items.size(), 2U);
  EXPECT_EQ(root.items[1].keys, root.items[0].keys);
  EXPECT_EQ(root.items[1].items[0].text, "1");
}

TEST(YamlTreeTest, RefusesAnAliasInsideItsAnchor) {
  EXPECT_THROW(static_cast<void>(read_yaml_text("a: &x [*x]\n", "f.yaml")), ConfigError);
}

TEST(MapViewTest, RefusesKeysOutsideTheSchema) {
  const std::string file = "f.yaml";
  const YamlNode root = read_yaml_text("domain: 1\n", file);
  planner::SourceFiles sources;
  const YamlSource source{file, sources};
  const MapView map = YamlView(root, source, "network").map(section::kNetwork);
  EXPECT_TRUE(map.find("domain").has_value());
  EXPECT_FALSE(map.find("peers").has_value());
  EXPECT_THROW(static_cast<void>(map.find("port")), std::logic_error);
}

}  // namespace
}  // namespace hecaton::config
