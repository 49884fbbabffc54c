// docs/reference/cell-file.md documents exactly the keys that the reader knows. (The reader cannot ask for a key that
// the schema does not list: MapView throws.)

#include "services/config/schema.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "planner/local/parameters.hpp"
#include "planner/methods/registry.hpp"

namespace hecaton::config {
namespace {

using Sections = std::map<std::string, std::set<std::string>>;

// "## `network`" opens a section, "| `domain` | …" documents a key of it.
Sections documented() {
  Sections sections;
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/reference/cell-file.md");
  std::set<std::string>* keys = nullptr;
  const auto between_ticks = [](const std::string& line, std::size_t from) {
    return line.substr(from, line.find('`', from) - from);
  };
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("#")) keys = nullptr;
    if (line.starts_with("## `")) keys = &sections[between_ticks(line, 4)];
    if (line.starts_with("| `") && keys != nullptr) {
      EXPECT_TRUE(keys->insert(between_ticks(line, 3)).second) << "twice: " << line;
    }
  }
  // "## `obstacles[].motion`" has what "## `obstacles[].motion of type sine`" shares with the other types.
  std::set<std::string> common;
  for (auto& [where, own] : sections) {
    const std::string above = where.substr(0, where.find(" of type "));
    if (above == where || !sections.contains(above)) continue;
    common.insert(above);
    for (const std::string& key : sections.at(above))
      EXPECT_TRUE(own.insert(key).second) << "twice: " << where << ' ' << key;
  }
  for (const std::string& where : common) sections.erase(where);
  return sections;
}

Sections known() {
  Sections sections;
  for (const Section* section : all_sections()) {
    auto& keys = sections[std::string(section->where)];
    for (const std::string_view key : section->keys) keys.emplace(key);
  }
  return sections;
}

TEST(SchemaTest, ReferenceListsExactlyTheKeys) {
  const Sections in_reference = documented();
  const Sections in_reader = known();
  for (const auto& [where, keys] : in_reader) {
    ASSERT_TRUE(in_reference.contains(where)) << "no heading for " << where;
    if (where == "defaults") {  // the reference says in a sentence that these are the keys of an arm
      EXPECT_TRUE(std::ranges::includes(in_reader.at("arms[]"), keys));
      continue;
    }
    EXPECT_EQ(in_reference.at(where), keys) << where;
  }
  for (const auto& [where, keys] : in_reference) EXPECT_TRUE(in_reader.contains(where)) << where << " does not exist";
}

TEST(SchemaTest, ReferenceNamesEveryMotionMethod) {
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/reference/cell-file.md");
  std::string row;
  while (std::getline(file, row) && !row.starts_with("| `method` |")) continue;
  for (const std::string_view name : planner::built_in_methods().names()) {
    EXPECT_NE(row.find("`" + std::string(name) + "`"), std::string::npos) << name;
  }
}

// Text of the column "default" by "arms[].damper influence_distance".
std::map<std::string, std::string> documented_defaults() {
  std::map<std::string, std::string> defaults;
  std::ifstream file(std::string(HECATON_SOURCE_DIR) + "/docs/reference/cell-file.md");
  std::string where;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## `")) where = line.substr(4, line.find('`', 4) - 4);
    if (!line.starts_with("| `")) continue;
    const std::string key = line.substr(3, line.find('`', 3) - 3);
    const std::size_t begin = line.find(" | ", line.find(" | ") + 3) + 3;
    defaults[where + ' ' + key] = line.substr(begin, line.find(" |", begin) - begin);
  }
  return defaults;
}

// Compares the reference with the parameters as they are constructed.
class DefaultComparison final : public planner::ParameterVisitor {
 public:
  void section(std::string_view key) override { section_ = "arms[]." + std::string(key); }
  void number(std::string_view name, double& value, const planner::ParameterRange&) override {
    if (section_ == "arms[].damper") {  // default_damper() computes them
      EXPECT_EQ(documented(name), "by reach and braking") << name;
      return;
    }
    EXPECT_NEAR(std::strtod(documented(name).c_str(), nullptr), value, 0.002 * value) << section_ << ' ' << name;
  }
  void seconds(std::string_view name, double& value, const planner::ParameterRange&) override {
    char* unit = nullptr;
    const std::string text = documented(name);
    const double number = std::strtod(text.c_str(), &unit);
    EXPECT_DOUBLE_EQ(std::string_view(unit) == "ms" ? number / 1000.0 : number, value) << section_ << ' ' << name;
  }
  void integer(std::string_view name, int& value, int, int) override {
    const std::string text = documented(name);
    EXPECT_EQ(value == 0 ? "all but the last" : std::to_string(value), text) << section_ << ' ' << name;
  }
  void boolean(std::string_view name, bool& value) override {
    EXPECT_EQ(documented(name), value ? "true" : "false") << section_ << ' ' << name;
  }
  void word(std::string_view name, std::span<const std::string_view> words, std::size_t& index) override {
    std::string text = documented(name);
    std::erase(text, '`');
    EXPECT_EQ(text, words[index]) << section_ << ' ' << name;
  }
  [[nodiscard]] int compared() const { return compared_; }

 private:
  std::string documented(std::string_view name) {
    ++compared_;
    return defaults_[section_ + ' ' + std::string(name)];
  }

  std::map<std::string, std::string> defaults_ = documented_defaults();
  std::string section_;
  int compared_ = 0;
};

TEST(SchemaTest, ReferenceGivesTheDefaultOfEveryPlanningParameter) {
  DefaultComparison comparison;
  planner::LocalParameters local;
  visit_parameters(local, comparison);
  for (const auto& method : planner::built_in_methods().make_all()) method->visit_parameters(comparison);
  EXPECT_GT(comparison.compared(), 25);
}

TEST(SchemaTest, OnlySectionsOfFreeNamesHaveNoKeys) {
  for (const Section* section : all_sections()) EXPECT_EQ(section->keys.empty(), section->free_names) << section->where;
}

}  // namespace
}  // namespace hecaton::config
