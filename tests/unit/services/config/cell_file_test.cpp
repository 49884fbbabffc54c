// Cell files that load, and their values.

#include "services/config/cell_file.hpp"

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

namespace hecaton::config {
namespace {

const std::string kCells = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/";

TEST(CellFileTest, ReadsThreePuma) {
  const CellFile file = load_cell_file(kCells + "three_puma.yaml");
  EXPECT_EQ(file.cell.name, "three_puma");
  EXPECT_EQ(file.network.domain, 42);
  ASSERT_EQ(file.cell.arms.size(), 3U);
  for (const auto& planned : file.cell.arms) {
    EXPECT_EQ(planned.arm.model->joints(), 6);
    EXPECT_EQ(planned.start, planned.arm.home());
    EXPECT_DOUBLE_EQ(planned.parameters.damper.influence_distance, 0.12);
    EXPECT_DOUBLE_EQ(planned.parameters.damper.security_distance, 0.03);
    for (int joint = 0; joint < 6; ++joint) {
      EXPECT_DOUBLE_EQ(planned.arm.limits.velocity[joint], 1.5);
      EXPECT_DOUBLE_EQ(planned.arm.limits.acceleration[joint], 10.0);
    }
    // Each base 0.7 m from the centre, its x axis pointing there.
    const world::Pose& X_WB = planned.arm.X_WB;
    EXPECT_NEAR(X_WB.translation().norm(), 0.7, 1e-12);
    EXPECT_LT((X_WB * Eigen::Vector3d(0.7, 0.0, 0.0)).norm(), 1e-12);
  }
  // The same URDF with the same options: one model for all.
  EXPECT_EQ(file.cell.arms[0].arm.model, file.cell.arms[2].arm.model);
}

TEST(CellFileTest, ReadsAHostForEachArmOfThreeHosts) {
  const CellFile file = load_cell_file(kCells + "three_hosts.yaml");
  EXPECT_EQ(file.network.discovery, Discovery::kUnicast);
  std::set<std::string> addresses;
  for (const Host& host : file.hosts) addresses.insert(host.address);
  EXPECT_EQ(addresses.size(), 5U);
  std::set<std::string> used{file.world_host, file.supervision.host};
  for (const ArmHosts& arm : file.arm_hosts) used.insert(arm.host);
  EXPECT_EQ(used.size(), 5U);
}

TEST(CellFileTest, ReadsStandbysOfThreeMachines) {
  const CellFile file = load_cell_file(kCells + "three_machines.yaml");
  EXPECT_EQ(file.hosts.size(), 3U);
  EXPECT_EQ(file.arm_hosts[1].host, "right-pc");
  EXPECT_FALSE(file.supervision.standby_host.empty());
  for (const ArmHosts& arm : file.arm_hosts) EXPECT_FALSE(arm.standby_host.empty());
}

// Users of the guide copy that file: the guide's table and excerpts must match it.
TEST(CellFileTest, MatchesTheGuide) {
  std::ifstream guide(std::string(HECATON_SOURCE_DIR) + "/docs/tutorials/three-machines.md");
  const std::string text{std::istreambuf_iterator<char>(guide), {}};
  EXPECT_NE(text.find("cells/three_machines.yaml /etc/hecaton/cell.yaml"), std::string::npos);
  for (const Host& host : load_cell_file(kCells + "three_machines.yaml").hosts) {
    EXPECT_NE(text.find("| " + host.address + " | `" + host.name + "` |"), std::string::npos) << host.name;
  }
  std::ifstream cell(kCells + "three_machines.yaml");
  std::set<std::string> lines;
  for (std::string line; std::getline(cell, line);) lines.insert(line);
  std::istringstream rows(text);
  bool inside = false;
  for (std::string line; std::getline(rows, line);) {
    if (line.starts_with("```")) {
      inside = line == "```yaml";
    } else if (inside) {
      EXPECT_TRUE(lines.contains(line)) << line;
    }
  }
}

TEST(CellFileTest, RefusesTwoTypesOfShapesOfOneName) {
  for (const char* name : {"box", "sphere"}) {
    auto shapes = shape_types();
    shapes.push_back({name, "radius [m]", {{"radius"}}, shapes.front().make});
    EXPECT_THROW(static_cast<void>(load_cell_file(kCells + "three_puma.yaml", {}, planner::built_in_methods(), shapes)),
                 std::invalid_argument)
        << name;
  }
}

}  // namespace
}  // namespace hecaton::config
