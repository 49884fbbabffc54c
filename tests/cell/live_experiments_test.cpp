// The three experiments of [Lahouar06, section 4], [Li96]'s arms and routes, with every part a process on DDS.
#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/child_process.hpp"
#include "tests/support/free_domain.hpp"

namespace hecaton {
namespace {

using namespace std::chrono_literals;

/// `hecaton up` on the real processes; the report it writes.
nlohmann::json run_live(const std::string& name, int tasks) {
  const test::FreeDomain domain;
  const auto report =
      std::filesystem::temp_directory_path() / ("hecaton_" + name + "_" + std::to_string(domain.number()) + ".json");
  test::ChildProcess up(
      "hecaton", {"--domain", std::to_string(domain.number()), "up", HECATON_LIVE_CELLS "/" + name + ".yaml", "--tasks",
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

// [Li96]: these arms know obstacles from their own sensors only, which the world simulates.
TEST(LiveExperiments, SensorsShowAPlanarArmItsWayOverDds) {
  EXPECT_EQ(run_live("planar_2r", 4)["reached"], 4);
}

TEST(LiveExperiments, SensorsShowAPumaItsWayOverDds) {
  EXPECT_EQ(run_live("puma_sensed", 4)["reached"], 4);
}

// Between two walls, with a cart that cuts the routes: no arm gets through without a route.
TEST(LiveExperiments, RoutesLeadThroughANarrowPassageOverDds) {
  EXPECT_EQ(run_live("narrow_passage", 3)["reached"], 3);
}

// Two discs exchange places in a corridor: by a plan that one proposes and the other joins.
TEST(LiveExperiments, APlanForBothLetsTwoArmsPassEachOtherOverDds) {
  EXPECT_EQ(run_live("corridor", 2)["reached"], 2);
}

}  // namespace
}  // namespace hecaton
