// Arms that know obstacles from their sensors only: docs/explanation/0011-sensed-cspace.md.
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "planner/methods/sensed_cspace/cspace_method.hpp"
#include "planner/simulation/batch.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::planner {
namespace {

Cell cell_of(const std::string& name) {
  return config::load_cell_file(std::string(HECATON_SOURCE_DIR) + "/deploy/cells/" + name + ".yaml").cell;
}

BatchReport simulate(Cell cell, const char* method, Remember remember, int tasks) {
  for (PlannedArm& planned : cell.arms) {
    planned.select_method(method);
    const auto& chosen = dynamic_cast<const cspace::CspaceMethod&>(*planned.parameters.method);
    const auto with = [&](auto changed) {
      changed.parameters.remember = remember;
      planned.parameters.method = std::make_shared<decltype(changed)>(changed);
    };
    if (chosen.traits().sensor_only) {
      with(dynamic_cast<const cspace::SensedCspace&>(chosen));
    } else {
      with(dynamic_cast<const cspace::KnownCspace&>(chosen));
    }
  }
  BatchOptions options;
  options.tasks = tasks;
  options.seed = 1996;
  return simulate_tasks(cell, options);
}

// About half of these scenes have a path. An arm that knows all obstacles reaches every goal that has one. An arm with
// sensors may miss some (docs/explanation/0011-sensed-cspace.md).
TEST(SensedCspace, ReachesGoalsInUnknownScenesWithoutContact) {
  const Cell cell = cell_of("planar_2r");
  const BatchReport known = simulate(cell, "known_cspace", Remember::kAlways, 25);
  EXPECT_EQ(known.contacts, 0U);
  EXPECT_GE(known.reached, 12);
  for (const Remember remember : {Remember::kUntilNearer, Remember::kAlways}) {
    const BatchReport sensed = simulate(cell, "sensed_cspace", remember, 25);
    EXPECT_EQ(sensed.contacts, 0U) << sensed.smallest.a << " – " << sensed.smallest.b;
    EXPECT_GE(sensed.reached, 10);
  }
}

// Arms that ignore the obstacles collide: the scenes are not trivial.
TEST(SensedCspace, ArmsWithoutSensorsCollideInTheseScenes) {
  Cell cell = cell_of("planar_2r");
  cell.arms[0].sensors.resize(1);
  cell.arms[0].sensors[0].rays.resize(1);
  cell.arms[0].sensors[0].range = 0.001;
  EXPECT_GT(simulate(cell, "sensed_cspace", Remember::kAlways, 25).contacts, 10U);
}

TEST(SensedCspace, ReachesGoalsInSpaceByPlanes) {
  const BatchReport sensed = simulate(cell_of("puma_sensed"), "sensed_cspace", Remember::kAlways, 4);
  EXPECT_EQ(sensed.contacts, 0U) << sensed.smallest.a << " – " << sensed.smallest.b;
  EXPECT_GE(sensed.reached, 3);
}

// The mapper of [Li96] misses cells. The margin covers most of what it misses in these scenes.
TEST(SensedCspace, MovesByThePublishedMapper) {
  const std::string path = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/planar_2r.yaml";
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  std::string published = text.str();
  const std::string margin = "margin: 0.03";
  published.insert(published.find(margin) + margin.size(), ", mapper: published");
  const Cell cell = config::parse_cell_file(published, path).cell;
  for (const char* method : {"known_cspace", "sensed_cspace"}) {
    const BatchReport by_published = simulate(cell, method, Remember::kAlways, 25);
    const BatchReport by_exact = simulate(cell_of("planar_2r"), method, Remember::kAlways, 25);
    EXPECT_GE(by_published.reached, 8) << method;
    EXPECT_NE(by_published.reach_times, by_exact.reach_times) << method;
  }
}

TEST(SensedCspace, IsRepeatable) {
  const Cell cell = cell_of("planar_2r");
  const BatchReport a = simulate(cell, "sensed_cspace", Remember::kUntilNearer, 5);
  const BatchReport b = simulate(cell, "sensed_cspace", Remember::kUntilNearer, 5);
  EXPECT_EQ(a.reach_times, b.reach_times);
  EXPECT_EQ(a.smallest.distance, b.smallest.distance);
}

}  // namespace
}  // namespace hecaton::planner
