// Damaged cell files either load or throw a ConfigError.

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/config/cell_file.hpp"

namespace hecaton::config {
namespace {

constexpr int kMutations = 2000;
const std::string kPath = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";

std::vector<std::string> read_lines(const std::string& path) {
  std::vector<std::string> lines;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

std::string join(const std::vector<std::string>& lines) {
  std::ostringstream text;
  for (const std::string& line : lines) text << line << '\n';
  return text.str();
}

class Mutator {
 public:
  explicit Mutator(std::vector<std::string> lines) : lines_(std::move(lines)) {}

  std::string next() {
    std::vector<std::string> lines = lines_;
    if (below(2) == 0) mutate_lines(lines);
    std::string text = join(lines);
    for (std::size_t count = below(4); count > 0 && !text.empty(); --count) mutate_bytes(text);
    return text;
  }

 private:
  std::size_t below(std::size_t limit) { return std::uniform_int_distribution<std::size_t>(0, limit - 1)(random_); }

  void mutate_lines(std::vector<std::string>& lines) {
    const std::size_t at = below(lines.size());
    const auto place = lines.begin() + static_cast<std::ptrdiff_t>(at);
    switch (below(4)) {
      case 0:
        lines.erase(place);
        break;
      case 1:
        lines.insert(place, lines[below(lines.size())]);
        break;
      case 2:
        std::swap(lines[at], lines[below(lines.size())]);
        break;
      default:
        lines[at].insert(0, below(5), ' ');
        break;
    }
  }

  void mutate_bytes(std::string& text) {
    // Bytes that mean something to YAML or to numbers find more than random ones.
    static const std::string kTelling = "[]{}:,#&*!|>%@'\"-+.eE0189 \n\t~?<\\";
    const std::size_t at = below(text.size());
    switch (below(5)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text[at] = kTelling[below(kTelling.size())];
        break;
      case 2:
        text.insert(at, 1, kTelling[below(kTelling.size())]);
        break;
      case 3:
        text.erase(at, 1 + below(8));
        break;
      default:
        text.insert(at, text.substr(below(text.size()), below(40)));
        break;
    }
  }

  std::vector<std::string> lines_;
  std::mt19937_64 random_{20240611};
};

TEST(MutationTest, LoadsOrRefusesDamagedFiles) {
  Mutator mutator(read_lines(kPath));
  int loaded = 0;
  int rejected = 0;
  for (int i = 0; i < kMutations; ++i) {
    const std::string text = mutator.next();
    try {
      const CellFile file = parse_cell_file(text, kPath);
      EXPECT_FALSE(file.cell.arms.empty());
      ++loaded;
    } catch (const ConfigError& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.starts_with(kPath + ": ")) << message;
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
      ++rejected;
    }  // anything else that is thrown fails the test
  }
  // Both outcomes must occur many times.
  EXPECT_GT(loaded, kMutations / 20);
  EXPECT_GT(rejected, kMutations / 20);
}

}  // namespace
}  // namespace hecaton::config
