// docs/reference/cell-file.md documents exactly the keys that the reader knows. (The reader cannot ask for a key that
// the schema does not list: MapView throws.)

#include "services/config/schema.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <string>

#include <gtest/gtest.h>

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
    if (line.starts_with("## `")) keys = &sections[between_ticks(line, 4)];
    if (line.starts_with("| `") && keys != nullptr) {
      EXPECT_TRUE(keys->insert(between_ticks(line, 3)).second) << "twice: " << line;
    }
  }
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

TEST(SchemaTest, ReferenceListsEveryKeyAndNoOther) {
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

TEST(SchemaTest, OnlySectionsOfFreeNamesHaveNoKeys) {
  for (const Section* section : all_sections()) EXPECT_EQ(section->keys.empty(), section->free_names) << section->where;
}

}  // namespace
}  // namespace hecaton::config
