// The files that keep what the filter of link pairs found.

#include "planner/collision/filter_cache.hpp"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include <sys/stat.h>

#include "planner/collision/model_filter.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

/// Makes this process keep its results in a temporary folder, until the end of the test.
class KeptResults {
 public:
  KeptResults() { keep_filter_results_in(place()); }
  ~KeptResults() { keep_filter_results_in({}); }
  KeptResults(const KeptResults&) = delete;
  KeptResults& operator=(const KeptResults&) = delete;

  [[nodiscard]] fs::path place() const { return fs::path(folder_.path()) / "caches" / "pairs"; }
  [[nodiscard]] std::vector<fs::path> files() const {
    std::vector<fs::path> all;
    for (const auto& entry : fs::directory_iterator(place())) all.push_back(entry.path());
    return all;
  }

 private:
  test::TemporaryFolder folder_;
};

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// Continuous joints, of which one is blocked, a close pair, pairs that always touch, and a pose of an SRDF.
struct BlockedArm {
  test::TemporaryFolder folder;
  std::string urdf = folder.write(
      "r.urdf",
      test::robot(
          test::ball_link("base", "0 0 -0.1") + test::ball_link("a", "0.2 0 0") + test::ball_link("b", "0.2 0 0") +
          test::ball_link("c", "0.06 0 0") +
          test::joint("j1", "continuous", "base", "a", R"(<axis xyz="0 0 1"/><limit effort="1" velocity="1"/>)") +
          test::joint("j2", "continuous", "a", "b",
                      R"(<origin xyz="0.2 0 0"/><axis xyz="0 0 1"/><limit effort="1" velocity="1"/>)") +
          test::joint("j3", "revolute", "b", "c", R"(<origin xyz="0.1 0 0"/><axis xyz="0 1 0"/>)" + test::kLimit)));
  UrdfOptions options = [this] {
    UrdfOptions made;
    made.srdf_path = folder.write("r.srdf", R"(<robot name="r"><group name="arm"><chain base_link="base" tip_link="c"/>
      </group><group_state name="up" group="arm"><joint name="j1" value="0.5"/><joint name="j2" value="-4"/>
      <joint name="j3" value="0"/></group_state></robot>)");
    return made;
  }();
};

void expect_same(const RobotModel& a, const RobotModel& b) {
  EXPECT_EQ(a.self_pairs, b.self_pairs);
  ASSERT_EQ(a.close_pairs.size(), b.close_pairs.size());
  for (std::size_t i = 0; i < a.close_pairs.size(); ++i) {
    EXPECT_EQ(a.close_pairs[i].first, b.close_pairs[i].first);
    EXPECT_EQ(a.close_pairs[i].second, b.close_pairs[i].second);
    EXPECT_EQ(a.close_pairs[i].widest, b.close_pairs[i].widest);
  }
  EXPECT_EQ(a.limits.lower, b.limits.lower);
  EXPECT_EQ(a.limits.upper, b.limits.upper);
  EXPECT_EQ(a.notes, b.notes);
  EXPECT_EQ(a.details, b.details);
  EXPECT_EQ(a.named, b.named);
  for (std::size_t i = 0; i < a.links.size(); ++i) EXPECT_EQ(a.links[i].joint_type, b.links[i].joint_type);
}

TEST(FilterCache, GivesTheModelThatTheFilterFound) {
  const BlockedArm arm;
  const std::vector<std::pair<std::string, UrdfOptions>> robots{
      {test::kPuma, {}},
      {std::string(HECATON_SOURCE_DIR) + "/deploy/robots/kr6_r900.urdf", {}},
      {std::string(HECATON_SOURCE_DIR) + "/deploy/robots/xarm6.urdf", {}},
      {arm.urdf, arm.options}};
  for (const auto& [urdf, options] : robots) {
    SCOPED_TRACE(urdf);
    const auto proven = load_arm_model(urdf, options);
    const KeptResults kept;
    expect_same(*load_arm_model(urdf, options), *proven);
    ASSERT_EQ(kept.files().size(), 1U);
    const auto before = load_urdf(urdf, options);
    const auto again = kept_filter_result(kept.place(), filter_inputs(*before, {}), *before);
    ASSERT_TRUE(again);
    expect_same(*again, *proven);
    EXPECT_EQ(again->geometry.size(), proven->geometry.size());
  }
}

TEST(FilterCache, IsReadByLoadArmModel) {
  const KeptResults kept;
  const auto before = load_urdf(test::kPuma);
  RobotModel marked = *load_arm_model(test::kPuma);
  marked.details.emplace_back("read from a file");
  keep_filter_result(kept.place(), filter_inputs(*before, {}), *before, marked);
  EXPECT_TRUE(test::has_note(*load_arm_model(test::kPuma), "read from a file"));
  keep_filter_results_in({});
  EXPECT_FALSE(test::has_note(*load_arm_model(test::kPuma), "read from a file")) << "without a folder";
}

TEST(FilterCache, HasOtherInputsForEachOtherRobotAndOption) {
  const RobotModel model = *load_urdf(test::kPuma);
  std::set<std::string> seen{filter_inputs(model, {})};
  const auto expect_new = [&seen](const char* what, const RobotModel& changed, const FilterOptions& options = {}) {
    EXPECT_TRUE(seen.insert(filter_inputs(changed, options)).second) << what;
  };
  const auto change = [&](const char* what, auto&& edit) {
    RobotModel changed = model;
    edit(changed);
    expect_new(what, changed);
  };
  change("place of a joint", [](RobotModel& one) { one.links[3].X_PJ.translation().x() += 1e-12; });
  change("axis", [](RobotModel& one) { one.links[3].axis = -one.links[3].axis; });
  change("limit", [](RobotModel& one) { one.limits.upper[2] -= 1e-12; });
  change("type", [](RobotModel& one) { one.links[3].joint_type = JointType::kPrismatic; });
  change("multiplier", [](RobotModel& one) { one.links[3].multiplier = 2.0; });
  change("name", [](RobotModel& one) { one.links[3].name += "x"; });
  change("place of a shape", [](RobotModel& one) { one.geometry[2].X_LS.translation().y() += 1e-12; });
  change("another shape", [](RobotModel& one) { one.geometry[2].shape = world::Sphere{0.07}; });
  change("size of a shape", [](RobotModel& one) { one.geometry[2].shape = world::Sphere{0.071}; });
  change("link of a shape", [](RobotModel& one) { ++one.geometry[2].link; });
  change("pairs", [](RobotModel& one) { one.self_pairs.pop_back(); });
  change("pose", [](RobotModel& one) { one.named["p"] = JointVector::Zero(one.joints()); });
  change("followers", [](RobotModel& one) { one.has_followers = true; });
  change("joint beside the chain", [](RobotModel& one) { one.beside["k"] = JointType::kRevolute; });
  expect_new("samples", model, {.samples = 501});
  expect_new("seed", model, {.random_seed = 2});
  expect_new("budget", model, {.proof_budget = 2001});
  expect_new("distance", model, {.apart = 0.021});
  EXPECT_NE(filter_inputs(model, {}).find(filter_code()), std::string::npos);
  EXPECT_EQ(filter_code().size(), 64U);
}

TEST(FilterCache, RefusesDamagedFiles) {
  const BlockedArm arm;
  const KeptResults kept;
  static_cast<void>(load_arm_model(arm.urdf, arm.options));
  const auto before = load_urdf(arm.urdf, arm.options);
  const std::string inputs = filter_inputs(*before, {});
  const fs::path file = file_of_filter(kept.place(), inputs);
  const std::string whole = bytes_of(file);
  const auto counts = [&](const std::string& bytes) {
    write_bytes(file, bytes);
    return kept_filter_result(kept.place(), inputs, *before).has_value();
  };
  ASSERT_TRUE(counts(whole));
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << (i % 8)));
    ASSERT_FALSE(counts(damaged)) << "byte " << i;
    if (i % 16 == 0) {
      ASSERT_FALSE(counts(whole.substr(0, i))) << "the first " << i;
    }
  }
  EXPECT_FALSE(counts(whole + '\0'));
  EXPECT_FALSE(counts(""));
  EXPECT_FALSE(kept_filter_result(kept.place() / "none", inputs, *before));
  // It is proven anew, and written again.
  write_bytes(file, whole.substr(0, whole.size() / 2));
  static_cast<void>(load_arm_model(arm.urdf, arm.options));
  EXPECT_EQ(bytes_of(file), whole);
}

TEST(FilterCache, RefusesFilesThatOthersMayWrite) {
  const KeptResults kept;
  static_cast<void>(load_arm_model(test::kPuma));
  const auto before = load_urdf(test::kPuma);
  const std::string inputs = filter_inputs(*before, {});
  const fs::path file = file_of_filter(kept.place(), inputs);
  const auto counts = [&] { return kept_filter_result(kept.place(), inputs, *before).has_value(); };
  EXPECT_TRUE(counts());
  ASSERT_EQ(chmod(file.c_str(), 0620), 0);
  EXPECT_FALSE(counts()) << "the group";
  ASSERT_EQ(chmod(file.c_str(), 0602), 0);
  EXPECT_FALSE(counts()) << "all users";
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  EXPECT_TRUE(counts());
  fs::rename(file, file.string() + "-real");
  fs::create_symlink(file.string() + "-real", file);
  EXPECT_FALSE(counts()) << "a symbolic link";
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_FALSE(counts()) << "a folder";
}

TEST(FilterCache, RefusesResultsThatTheFilterNeverHas) {
  const KeptResults kept;
  const auto before = load_urdf(test::kPuma);
  const std::string inputs = filter_inputs(*before, {});
  const RobotModel good = *load_arm_model(test::kPuma);
  const auto counts = [&](auto&& edit) {
    RobotModel result = good;
    edit(result);
    keep_filter_result(kept.place(), inputs, *before, result);
    return kept_filter_result(kept.place(), inputs, *before).has_value();
  };
  EXPECT_TRUE(counts([](RobotModel&) {}));
  EXPECT_FALSE(counts([](RobotModel& one) { one.self_pairs.emplace_back(0, 99); }));
  EXPECT_FALSE(counts([](RobotModel& one) { one.close_pairs.push_back({1, 2, 0.1}); })) << "no pair of the model";
  EXPECT_FALSE(counts([](RobotModel& one) {
    one.close_pairs.push_back({one.self_pairs[0].first, one.self_pairs[0].second, -0.1});
  }));
  EXPECT_FALSE(counts([](RobotModel& one) { one.limits.upper[0] += 1e-9; }));
  EXPECT_FALSE(counts([](RobotModel& one) { one.limits.lower[0] = std::nan(""); }));
  EXPECT_FALSE(counts([](RobotModel& one) { one.limits.lower = JointVector::Zero(2); }));
  EXPECT_FALSE(counts([](RobotModel& one) { one.links[2].joint_type = JointType::kFixed; }));
  EXPECT_FALSE(counts([](RobotModel& one) { one.named["other"] = JointVector::Zero(one.joints()); }));
}

TEST(FilterCache, DoesWithoutAFolderThatCannotBeWritten) {
  const test::TemporaryFolder folder;
  keep_filter_results_in(fs::path(folder.write("file", "")) / "below");
  EXPECT_EQ(load_arm_model(test::kPuma)->self_pairs, load_arm_model(test::kPuma)->self_pairs);
  keep_filter_results_in({});
}

TEST(FilterCache, RemovesTheOldestFiles) {
  const KeptResults kept;
  fs::create_directories(kept.place());
  const auto now = fs::file_time_type::clock::now();
  for (int i = 0; i < 300; ++i) {
    const fs::path file = kept.place() / std::to_string(i);
    write_bytes(file, "old");
    fs::last_write_time(file, now - std::chrono::hours(1 + i));
  }
  static_cast<void>(load_arm_model(test::kPuma));
  EXPECT_EQ(kept.files().size(), 256U);
  EXPECT_TRUE(fs::exists(kept.place() / "0"));
  EXPECT_FALSE(fs::exists(kept.place() / "299"));
  const auto before = load_urdf(test::kPuma);
  EXPECT_TRUE(kept_filter_result(kept.place(), filter_inputs(*before, {}), *before));
}

}  // namespace
}  // namespace hecaton::planner
