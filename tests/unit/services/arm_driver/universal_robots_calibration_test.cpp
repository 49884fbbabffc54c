// Whether a robot and its description have the same kinematics. No network.
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "planner/model/fixed_links.hpp"
#include "services/arm_driver/devices/universal_robots/calibration.hpp"
#include "services/arm_driver/devices/universal_robots/primary.hpp"
#include "services/arm_driver/devices/universal_robots/universal_robots_arm.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/services/arm_driver/universal_robots_setup.hpp"

namespace hecaton::services {
namespace {

using test::ur_description;
using test::ur_setup;

/// Parameters that the maker publishes: a2, a3, d1, d4, d5, d6 [m].
device::universal_robots::DhParameters published(const std::array<double, 6>& lengths) {
  constexpr double kRight = std::numbers::pi / 2.0;
  device::universal_robots::DhParameters dh;
  dh.a = {0.0, lengths[0], lengths[1], 0.0, 0.0, 0.0};
  dh.d = {lengths[2], 0.0, 0.0, lengths[3], lengths[4], lengths[5]};
  dh.alpha = {kRight, 0.0, 0.0, kRight, -kRight, 0.0};
  return dh;
}
constexpr std::array kUr5e{-0.425, -0.3922, 0.1625, 0.1333, 0.0997, 0.0996};

TEST(UniversalRobots, ComparesTheFlangeWithThatOfADescription) {
  const std::map<std::string, std::array<double, 6>> types{
      {"ur3e", {-0.24355, -0.2132, 0.15185, 0.13105, 0.08535, 0.0921}},
      {"ur5e", kUr5e},
      {"ur10e", {-0.6127, -0.57155, 0.1807, 0.17415, 0.11985, 0.11655}},
      {"ur16e", {-0.4784, -0.36, 0.1807, 0.17415, 0.11985, 0.11655}}};
  for (const auto& [type, lengths] : types) {
    const auto model = ur_description(type);
    for (const auto& [other, others] : types) {
      const auto difference = flange_difference(published(others), *model);
      ASSERT_TRUE(difference);
      if (type == other) {
        EXPECT_LT(*difference, 1e-6) << type;
      } else {
        EXPECT_GT(*difference, 0.05) << type << " and " << other;
      }
    }
  }
  const auto model = ur_description("ur5e");
  for (const auto& [member, change] :
       {std::pair(0, 1e-3), std::pair(1, 1e-3), std::pair(3, 1e-3), std::pair(4, 1e-3)}) {
    auto lengths = kUr5e;
    lengths[member] += change;
    EXPECT_NEAR(*flange_difference(published(lengths), *model), 1e-3, 1e-6) << member;
  }
  for (std::size_t joint = 1; joint < 5; ++joint) {
    auto dh = published(kUr5e);
    dh.theta[joint] += 0.01;
    EXPECT_GT(*flange_difference(dh, *model), 9e-4) << "joint " << joint << " has another zero";
    dh = published(kUr5e);
    dh.alpha[joint - 1] += 0.01;
    EXPECT_GT(*flange_difference(dh, *model), 9e-4) << "an axis behind joint " << joint << " is tilted";
  }
}

TEST(UniversalRobots, ComparesTheFlangeAlsoWithOtherFramesAndAMount) {
  planner::RobotModel model = *ur_description("ur5e");
  const auto moving = [&](int joint) {
    return std::find_if(model.links.begin(), model.links.end(), [&](const auto& link) { return link.joint == joint; });
  };
  // A mount; and frames of a joint that are elsewhere on its axis.
  moving(0)->X_PJ = planner::Pose(Eigen::Translation3d(0.3, -0.2, 0.8) *
                                  Eigen::AngleAxisd(2.5, Eigen::Vector3d(1.0, 2.0, 0.5).normalized())) *
                    moving(0)->X_PJ;
  const auto fifth = moving(4);
  fifth->X_PJ = fifth->X_PJ * Eigen::Translation3d(0.07 * fifth->axis);
  const auto sixth = moving(5);
  sixth->X_PJ = Eigen::Translation3d(-0.07 * fifth->axis) * sixth->X_PJ * Eigen::Translation3d(0.05 * sixth->axis);
  EXPECT_LT(*flange_difference(published(kUr5e), model), 1e-6);
  for (int joint = 0; joint < 5; ++joint) {
    planner::RobotModel reversed = model;
    for (planner::Link& link : reversed.links) {
      if (link.joint == joint) link.axis = -link.axis;
      link.motion = joint_motion(link);
    }
    EXPECT_GT(*flange_difference(published(kUr5e), reversed), 0.05) << "joint " << joint << " turns the other way";
  }
  model.has_followers = true;
  EXPECT_FALSE(flange_difference(published(kUr5e), model));
}

TEST(UniversalRobots, ComparesShoulderAndFlangeInTheFramesOfRos) {
  constexpr double kMost = 0.01;
  for (const std::string type : {"ur3e", "ur5e", "ur10e", "ur16e"}) {
    const auto model = ur_description(type);
    const auto named = [&](const std::string& name) {
      return std::any_of(model->links.begin(), model->links.end(), [&](const auto& link) { return link.name == name; });
    };
    EXPECT_TRUE(named("base_link") && named("tool0")) << type;
  }
  planner::RobotModel model = *ur_description("ur5e");
  EXPECT_NEAR(*length_difference(published(kUr5e), model, kMost), 0.0, 1e-6);
  for (const int member : {2, 5}) {
    auto lengths = kUr5e;
    lengths[member] += 2e-3;
    EXPECT_LT(*flange_difference(published(lengths), model), 1e-6) << member;
    EXPECT_NEAR(*length_difference(published(lengths), model, kMost), 2e-3, 1e-6) << member;
  }
  for (planner::Link& link : model.links) link.name.insert(0, "left_");
  EXPECT_TRUE(length_difference(published(kUr5e), model, kMost));
  // A pedestal, and a base_link beside the arm.
  const auto first =
      std::find_if(model.links.begin(), model.links.end(), [](const auto& link) { return link.joint == 0; });
  for (const Eigen::Vector3d& mount : {Eigen::Vector3d(0.0, 0.0, 0.8), Eigen::Vector3d(0.3, 0.0, 0.0)}) {
    planner::RobotModel mounted = model;
    planner::Link& moving = mounted.links[static_cast<std::size_t>(first - model.links.begin())];
    moving.X_PJ = Eigen::Translation3d(mount) * moving.X_PJ;
    auto lengths = kUr5e;
    lengths[2] += 2e-3;
    EXPECT_NEAR(*length_difference(published(lengths), mounted, kMost), 0.0, 1e-6) << "only tool0 counts";
  }
  for (planner::Link& link : model.links) link.name = "link";
  EXPECT_FALSE(length_difference(published(kUr5e), model, kMost));
}

TEST(UniversalRobots, KeepsTheComparisonFiniteWithAnyParameters) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1e6, 1e6);
  const auto model = ur_description("ur5e");
  for (int i = 0; i < 2000; ++i) {
    device::universal_robots::DhParameters dh;
    for (auto* values : {&dh.theta, &dh.a, &dh.d, &dh.alpha}) {
      for (double& value : *values) value = random() % 3 == 0 ? 0.0 : any(random);
    }
    EXPECT_TRUE(std::isfinite(*flange_difference(dh, *model)));
    EXPECT_LE(length_difference(dh, *model, 0.01).value_or(0.0), 0.01);
  }
  EXPECT_GT(*flange_difference(device::universal_robots::DhParameters(), *model), 0.1);
}

TEST(UniversalRobots, TakesPackagesOfThePrimaryPortFromRandomBytes) {
  std::mt19937 random(5);
  int packages = 0, broken = 0, kinematics = 0;
  // Two states with kinematics, some bytes of which are others or missing.
  const std::string header{'\0', '\0', '\0', '\xE6', 16, '\0', '\0', '\0', '\xE1', 5};
  const std::string state = header + std::string(220, '\0');
  for (int i = 0; i < 100'000; ++i) {
    std::string bytes = state + state;
    for (std::size_t changes = random() % 4; changes > 0; --changes) {
      bytes[random() % (random() % 2 == 0 ? header.size() : bytes.size())] = static_cast<char>(random());
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    std::string_view left = bytes;
    for (bool goes_on = true; goes_on;) {
      const auto next = device::universal_robots::next_primary_package(left);
      ASSERT_LE(next.size, left.size());
      packages += next.size > 0 ? 1 : 0;
      broken += next.broken.empty() ? 0 : 1;
      kinematics += next.kinematics ? 1 : 0;
      goes_on = next.size > 0;
      left.remove_prefix(next.size);
    }
  }
  EXPECT_GT(packages, 10'000);
  EXPECT_GT(broken, 10'000);
  EXPECT_GT(kinematics, 10'000);
}

TEST(UniversalRobots, SaysThatADescriptionHasNoCalibration) {
  planner::RobotModel model;
  model.links.resize(2);
  for (int joint = 0; joint < 2; ++joint) model.links[joint].joint = joint;
  const auto notes = [&] { return universal_robots_notes(ur_setup("192.168.0.10", {{"model", "ur5e"}}), model); };
  ASSERT_EQ(notes().size(), 2U);
  EXPECT_NE(notes()[0].find("without the calibration of this robot"), std::string::npos) << notes()[0];
  model.links[1].X_PJ.rotate(Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitX()));
  EXPECT_EQ(notes().size(), 1U) << "a calibration turns the frames by a little";
  EXPECT_EQ(universal_robots_notes(ur_setup("192.168.0.10"), model).front(),
            "arm north: its description does not name a model of Universal Robots, so that a wrong robot is not found; "
            "the key model of its device names it");
}

// Where a robot has many links, the mount is a part of the first joint's frame.
TEST(UniversalRobots, CountsATiltedMountAsNoCalibration) {
  const test::TemporaryFolder folder;
  std::ifstream file(HECATON_SOURCE_DIR "/deploy/robots/ur5e.urdf");
  std::string text{std::istreambuf_iterator<char>(file), {}};
  const std::string base = "<link name=\"base_link\">";
  ASSERT_NE(text.find(base), std::string::npos);
  text.insert(text.find(base),
              "<link name='floor'/><joint name='mount' type='fixed'><parent link='floor'/><child link='base_link'/>"
              "<origin rpy='0.785398163397 0 0'/></joint>");
  planner::RobotModel model = *planner::load_urdf(folder.write("mounted.urdf", text));
  planner::merge_fixed_links(static_cast<int>(model.links.size()) - 1, model);
  ASSERT_EQ(model.links[1].joint, 0);
  ASSERT_NEAR(model.links[1].X_PJ.linear()(1, 1), std::sqrt(0.5), 1e-9);
  EXPECT_NE(universal_robots_notes(ur_setup("192.168.0.10"), model).front().find("without the calibration"),
            std::string::npos);
}

}  // namespace
}  // namespace hecaton::services
