// Passes the seeds and the regression inputs of each fuzz target to it. A target aborts the process, or a sanitizer
// does.

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "services/bus/topics.hpp"
#include "services/bus/wire_rules.hpp"

#define HECATON_TARGET(name) extern "C" int fuzz_##name(const std::uint8_t* data, std::size_t size);
#include "targets.inc"
#undef HECATON_TARGET

namespace hecaton::fuzz {
namespace {

struct Target {
  const char* name;
  int (*run)(const std::uint8_t* data, std::size_t size);

  friend std::ostream& operator<<(std::ostream& to, const Target& target) { return to << target.name; }
};

#define HECATON_TARGET(name) {#name, fuzz_##name},
constexpr std::array kTargets = std::to_array<Target>({
#include "targets.inc"
});
#undef HECATON_TARGET

/// Plain files below `folder`, in order of their names.
std::vector<std::filesystem::path> files_in(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

class FuzzReplay : public testing::TestWithParam<Target> {};

TEST_P(FuzzReplay, SurvivesEachInput) {
  const auto [name, run] = GetParam();
  const std::filesystem::path here = std::filesystem::path(HECATON_SOURCE_DIR) / "tests/fuzz";
  const auto corpus = files_in(here / "corpus" / name);
  EXPECT_FALSE(corpus.empty()) << "a target needs seeds: " << here / "corpus" / name;
  EXPECT_EQ(run(nullptr, 0), 0);
  for (const auto& files : {corpus, files_in(here / "regressions" / name)}) {
    for (const std::filesystem::path& file : files) {
      SCOPED_TRACE(file);
      std::ifstream stream(file, std::ios::binary);
      const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
      EXPECT_EQ(run(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()), 0);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay, testing::ValuesIn(kTargets),
                         [](const auto& one) { return std::string(one.param.name); });

// After a change of a message or of the table of topics, `fuzz_seeds tests/fuzz/corpus` writes them anew.
TEST(Seeds, OfSamplesHaveTheTopicsAndSchemaOfToday) {
  const std::filesystem::path here = std::filesystem::path(HECATON_SOURCE_DIR) / "tests/fuzz/corpus/samples";
  for (std::size_t topic = 0; topic < bus::kTopics.size(); ++topic) {
    const std::string type(bus::kTopics[topic].type);
    SCOPED_TRACE(type);
    std::ifstream stream(here / (type + "_full"), std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(stream), {}};
    ASSERT_GT(bytes.size(), 1U);
    EXPECT_EQ(bytes[0], topic);
    const bus::CheckedSample checked = bus::check_sample(*bus::topic_rule(type), std::span(bytes).subspan(1));
    EXPECT_FALSE(checked.other_schema);
    EXPECT_EQ(checked.refusal, std::nullopt);
  }
}

}  // namespace
}  // namespace hecaton::fuzz
