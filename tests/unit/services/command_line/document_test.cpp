#include "services/command_line/document.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace hecaton::services::cli {
namespace {

TEST(JsonText, KeepsOrderAndReadsBackTheSame) {
  const Json value{{"z", 0.1}, {"a", {1, 2}}, {"n", nullptr}};
  const std::string text = json_text(value);
  EXPECT_LT(text.find("\"z\""), text.find("\"a\""));
  EXPECT_EQ(Json::parse(text), value);
  EXPECT_EQ(Json::parse(json_text(0.1 + 0.2)).get<double>(), 0.1 + 0.2);
}

TEST(JsonText, WritesNullForNumbersThatAreNotFinite) {
  EXPECT_EQ(json_text(Json{{"x", std::nan("")}}), "{\n  \"x\": null\n}\n");
}

TEST(JsonText, ReplacesInvalidUtf8) {
  EXPECT_NO_THROW(static_cast<void>(json_text(Json{{"x", "\xff"}})));
}

TEST(YamlText, IndentsMapsAndLists) {
  const Json value{{"cell", "c: 1"},
                   {"q", {0.5, 1}},
                   {"arms", {{{"name", "north"}, {"state", {{"mode", "run"}}}}, {{"name", "west"}}}},
                   {"none", Json::array()},
                   {"goal", nullptr}};
  EXPECT_EQ(yaml_text(value),
            "\"cell\": \"c: 1\"\n"
            "\"q\": [0.5, 1]\n"
            "\"arms\":\n"
            "  - \"name\": \"north\"\n"
            "    \"state\":\n"
            "      \"mode\": \"run\"\n"
            "  - \"name\": \"west\"\n"
            "\"none\": []\n"
            "\"goal\": null\n");
}

TEST(YamlText, WritesListsAtTheTop) {
  EXPECT_EQ(yaml_text(Json::array({Json{{"a", 1}}, Json{{"b", 2}}})), "- \"a\": 1\n- \"b\": 2\n");
  EXPECT_EQ(yaml_text(Json::array()), "[]\n");
}

}  // namespace
}  // namespace hecaton::services::cli
