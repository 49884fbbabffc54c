// Merging of fixed links keeps all places and pairs.

#include "planner/model/fixed_links.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "planner/model/kinematics.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::joint;
using test::kLimit;

const std::string kRobot =
    test::robot(ball_link("base") + ball_link("head", "0 0 0.1") + R"(<link name="eye"/>)" + ball_link("a") +
                ball_link("cover") + ball_link("b") + R"(<link name="tool"/>)" +
                joint("f1", "fixed", "base", "head", R"(<origin xyz="0 0 1" rpy="0.3 0 0"/>)") +
                joint("f2", "fixed", "head", "eye", R"(<origin xyz="0.1 0 0"/>)") +
                joint("j1", "revolute", "eye", "a", R"(<origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>)" + kLimit) +
                joint("f3", "fixed", "a", "cover", R"(<origin xyz="0 0.2 0" rpy="0 1 0"/>)") +
                joint("j2", "revolute", "cover", "b", R"(<origin xyz="0.5 0 0"/><axis xyz="0 1 0"/>)" + kLimit) +
                joint("f4", "fixed", "b", "tool", R"(<origin xyz="0.2 0 0"/>)"));

/// Centres of the shapes in W, without order.
std::multiset<std::array<long, 3>> places(const RobotModel& model, const JointVector& q) {
  Kinematics kinematics;
  forward_kinematics(model, Pose::Identity(), q, kinematics);
  std::multiset<std::array<long, 3>> centres;
  for (const LinkGeometry& geometry : model.geometry) {
    const Eigen::Vector3d p = (kinematics.X_WL[geometry.link] * geometry.X_LS).translation();
    centres.insert({std::lround(p.x() * 1e9), std::lround(p.y() * 1e9), std::lround(p.z() * 1e9)});
  }
  return centres;
}

TEST(FixedLinks, KeepTheirPlacesWhenTheyAreMerged) {
  const auto whole = test::load_text(kRobot);
  for (const int most : {6, 5, 4, 3}) {
    RobotModel merged = *whole;
    merge_fixed_links(most, merged);
    EXPECT_EQ(merged.links.size(), static_cast<std::size_t>(std::max(most, 4))) << "base, a, b and the tool stay";
    EXPECT_EQ(merged.links[merged.tool_link].name, "tool");
    EXPECT_TRUE(test::has_note(merged, "the robot has 7 links"));
    JointVector q(2);
    q << 0.7, -0.4;
    EXPECT_EQ(places(merged, q), places(*whole, q));
    Kinematics one;
    Kinematics two;
    forward_kinematics(merged, Pose::Identity(), q, one);
    forward_kinematics(*whole, Pose::Identity(), q, two);
    EXPECT_TRUE(one.X_WT.isApprox(two.X_WT, 1e-12));
    EXPECT_TRUE(std::is_sorted(merged.geometry.begin(), merged.geometry.end(),
                               [](const LinkGeometry& a, const LinkGeometry& b) { return a.link < b.link; }));
    EXPECT_EQ(merged.self_pairs.size(), whole->self_pairs.size());
    for (const auto& [a, b] : merged.self_pairs) {
      EXPECT_GT(std::abs(axes_before(merged, merged.geometry[a].link) - axes_before(merged, merged.geometry[b].link)),
                1);
    }
  }
}

TEST(FixedLinks, StayIfThereAreFewEnough) {
  RobotModel model = *test::load_text(kRobot);
  merge_fixed_links(7, model);
  EXPECT_EQ(model.links.size(), 7U);
  EXPECT_FALSE(test::has_note(model, "merged"));
}

}  // namespace
}  // namespace hecaton::planner
