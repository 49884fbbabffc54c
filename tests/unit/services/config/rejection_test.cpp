// The reader rejects every cell file in tests/data/bad with one sentence that contains the text of its "# expect:"
// lines.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/config/cell_file.hpp"

namespace hecaton::config {
namespace {

const std::string kFolder = std::string(HECATON_SOURCE_DIR) + "/tests/data/bad";

std::vector<std::string> bad_files() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kFolder)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<std::string> expected_pieces(const std::string& path) {
  const std::string mark = "# expect: ";
  std::vector<std::string> pieces;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(mark)) pieces.push_back(line.substr(mark.size()));
  }
  return pieces;
}

class RejectionTest : public testing::TestWithParam<std::string> {};

TEST_P(RejectionTest, NamesFileKeyValueAndRule) {
  const std::string path = kFolder + "/" + GetParam() + ".yaml";
  const auto pieces = expected_pieces(path);
  ASSERT_FALSE(pieces.empty()) << "no '# expect:' line";
  try {
    static_cast<void>(load_cell_file(path));
    FAIL() << "was accepted";
  } catch (const ConfigError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(message.starts_with(path + ": ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& piece : pieces) {
      EXPECT_NE(message.find(piece, path.size()), std::string::npos) << "no '" << piece << "' in: " << message;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(BadCells, RejectionTest, testing::ValuesIn(bad_files()),
                         [](const auto& param_info) { return param_info.param; });

TEST(RejectionOfFilesTest, NamesUnreadableFiles) {
  for (const std::string& path : {kFolder + "/there_is_none.yaml", kFolder}) {
    try {
      static_cast<void>(load_cell_file(path));
      FAIL() << "was accepted";
    } catch (const ConfigError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with(path + ": ")) << error.what();
    }
  }
}

// 20 levels of lists whose items are aliases of the level below would be a million values.
TEST(RejectionOfFilesTest, LimitsTheExpansionOfAliases) {
  std::ostringstream text;
  text << "name: bomb\na0: &a0 [1, 1]\n";
  for (int level = 1; level < 20; ++level) {
    text << "a" << level << ": &a" << level << " [*a" << level - 1 << ", *a" << level - 1 << "]\n";
  }
  EXPECT_THROW(static_cast<void>(parse_cell_file(text.str(), "bomb.yaml")), ConfigError);
}

TEST(RejectionOfFilesTest, RefusesDeepNesting) {
  const std::string text = "name: " + std::string(100'000, '[');
  EXPECT_THROW(static_cast<void>(parse_cell_file(text, "deep.yaml")), ConfigError);
}

}  // namespace
}  // namespace hecaton::config
