// The three experiments of [Lahouar06, section 4] on our cells: the local planner alone fails where the paper says so,
// boundary following succeeds, the referee sees no contact; in virtual time and with every part a process on DDS.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton {
namespace {

using namespace std::chrono_literals;

std::string cell_path(const std::string& name) {
  return HECATON_SOURCE_DIR "/deploy/cells/" + name + ".yaml";
}

/// `candidates`: of the rollouts; 0: as the paper plans.
planner::BatchReport simulate(const std::string& name, planner::Method method, int tasks, int candidates = 0) {
  planner::Cell cell = config::load_cell_file(cell_path(name)).cell;
  for (auto& arm : cell.arms) {
    arm.parameters.method = method;
    arm.parameters.rollout.candidates = candidates;
  }
  planner::BatchOptions options;
  options.tasks = tasks;
  options.seed = 11;
  options.threads = 2;
  const planner::BatchReport report = planner::simulate_tasks(cell, options);
  EXPECT_EQ(report.failure, "");
  EXPECT_EQ(report.tasks, tasks);
  EXPECT_EQ(report.contacts, 0U) << report.smallest.a << " – " << report.smallest.b;
  EXPECT_TRUE(report.judged);
  EXPECT_GT(report.smallest.distance, 0.0);
  return report;
}

// Fig. 12: "These results can not be reached by using only the local planner."
TEST(Experiments, OnlyBoundaryFollowingTakesTheBarThroughTheLadder) {
  EXPECT_EQ(simulate("puma_ladder", planner::Method::kLocal, 10).reached, 0);
  EXPECT_GE(simulate("puma_ladder", planner::Method::kBoundaryFollowing, 20).reached, 14);
}

// Looking ahead finds the way through at once, where following boundaries in subspaces drawn blindly takes up to
// minutes.
TEST(Experiments, WithRolloutsTheBarPassesTheLadderAlwaysAndSoon) {
  const planner::BatchReport report = simulate("puma_ladder", planner::Method::kBoundaryFollowing, 20, 8);
  EXPECT_EQ(report.reached, 20);
  EXPECT_LT(*std::max_element(report.times.begin(), report.times.end()), 15.0);
}

// Fig. 13: "This task would not be possible if we used only the local planner."
TEST(Experiments, OnlyBoundaryFollowingExchangesTheCarriedObjects) {
  EXPECT_EQ(simulate("two_puma_carry", planner::Method::kLocal, 10).reached, 0);
  EXPECT_EQ(simulate("two_puma_carry", planner::Method::kBoundaryFollowing, 40).reached, 40);
}

// Fig. 14. The paper does not say that the local planner always fails here, and it does not: it loses some goals for
// good.
TEST(Experiments, ThreeArmsExchangePlaces) {
  const int alone = simulate("three_puma", planner::Method::kLocal, 300).reached;
  const int following = simulate("three_puma", planner::Method::kBoundaryFollowing, 300).reached;
  EXPECT_LT(alone, 297);
  EXPECT_GE(following, 297);
}

// The hard set: each arm stands in another's straight way.
TEST(Experiments, WithRolloutsAllHardTasksAreReached) {
  EXPECT_LT(simulate("three_puma_dense", planner::Method::kLocal, 90).reached, 80);
  EXPECT_EQ(simulate("three_puma_dense", planner::Method::kBoundaryFollowing, 90, 8).reached, 90);
}

TEST(Experiments, SimulationIsTheSameForASeedWhateverTheThreads) {
  const planner::Cell cell = config::load_cell_file(cell_path("two_puma_carry")).cell;
  planner::BatchOptions options;
  options.tasks = 12;
  options.seed = 5;
  const planner::BatchReport one = planner::simulate_tasks(cell, options);
  options.threads = 3;
  const planner::BatchReport three = planner::simulate_tasks(cell, options);
  EXPECT_EQ(one.times, three.times);
  EXPECT_EQ(one.duration, three.duration);
  EXPECT_EQ(one.smallest.distance, three.smallest.distance);
  options.seed = 6;
  EXPECT_NE(planner::simulate_tasks(cell, options).times, one.times);
}

/// `hecaton up` on the real processes; the report it writes.
nlohmann::json run_live(const std::string& name, int tasks) {
  const test::FreeDomain domain;
  const auto report =
      std::filesystem::temp_directory_path() / ("hecaton_" + name + "_" + std::to_string(domain.number()) + ".json");
  test::ChildProcess up("hecaton", {"--domain", std::to_string(domain.number()), "up", cell_path(name), "--tasks",
                                    std::to_string(tasks), "--seed", "3", "--headless", "--report", report.string()});
  const test::Exit exit = up.wait(std::chrono::duration_cast<std::chrono::milliseconds>(8min));
  EXPECT_TRUE(exit.ended);
  std::ifstream file(report);
  nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  std::filesystem::remove(report);
  EXPECT_FALSE(json.is_discarded());
  EXPECT_EQ(json["tasks"], tasks);
  EXPECT_EQ(json["contacts"], 0);
  EXPECT_GT(json["min_separation_m"], 0.0);
  return json;
}

TEST(LiveExperiments, TheBarPassesTheLadderOverDds) {
  EXPECT_EQ(run_live("puma_ladder", 4)["reached"], 4);
}

TEST(LiveExperiments, CarriedObjectsChangeSidesOverDds) {
  EXPECT_EQ(run_live("two_puma_carry", 4)["reached"], 4);
}

TEST(LiveExperiments, ThreeArmsExchangePlacesOverDds) {
  EXPECT_EQ(run_live("three_puma", 9)["reached"], 9);
}

}  // namespace
}  // namespace hecaton
