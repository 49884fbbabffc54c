// Mechanisms beside the chain: their shapes enclose all places where they may be.

#include "planner/model/followers.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "planner/model/convex_hull.hpp"
#include "planner/model/kinematics.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::ball_link;
using test::has_note;
using test::joint;
using test::kLimit;
using test::load_text;
using test::robot;

/// A link with a box of 0.4 m along x that begins at the joint.
std::string rod_link(const std::string& name) {
  return "<link name=\"" + name +
         R"("><collision><origin xyz="0.2 0 0"/><geometry><box size="0.4 0.02 0.02"/></geometry></collision></link>)";
}

const std::string kArm = ball_link("base") + rod_link("a") + rod_link("b") +
                         joint("j1", "revolute", "base", "a", R"(<axis xyz="0 1 0"/>)" + kLimit) +
                         joint("j2", "revolute", "a", "b", R"(<origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>)" + kLimit);

std::string cylinder_on(const std::string& parent, const std::string& mimic) {
  return rod_link("cylinder") +
         joint("jc", "revolute", parent, "cylinder", R"(<origin xyz="-0.1 0 0.1"/><axis xyz="0 1 0"/>)" + mimic);
}

const LinkGeometry& geometry_of(const RobotModel& model, const std::string& link) {
  for (const LinkGeometry& geometry : model.geometry) {
    if (model.links[geometry.link].name == link) return geometry;
  }
  throw std::logic_error("no geometry on " + link);
}

/// The largest distance by which `p`, in the frame of the geometry's link, is outside its hull [m].
double outside(const LinkGeometry& geometry, const Eigen::Vector3d& p) {
  const world::ConvexHull& hull = *std::get<world::Convex>(geometry.shape).hull;
  double worst = -INFINITY;
  for (int face = 0; face < static_cast<int>(hull.faces.size()); ++face) {
    const FacePlane plane = face_plane(hull, face);
    worst = std::max(worst, plane.normal.dot(geometry.X_LS.inverse() * p) - plane.offset);
  }
  return worst;
}

TEST(Followers, EncloseAllPlacesOfACylinder) {
  const auto model =
      load_text(robot(kArm + cylinder_on("base", R"(<mimic joint="j1" multiplier="0.5" offset="0.3"/>)")));
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"j1", "j2"}));
  EXPECT_TRUE(has_note(*model, "links beside the chain follow its joints"));
  const LinkGeometry& swept = geometry_of(*model, "cylinder");
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(2), kinematics);
  const Pose X_LW = kinematics.X_WL[swept.link].inverse();
  double nearest = -INFINITY;
  for (int i = 0; i <= 400; ++i) {
    const double q1 = -2.0 + 0.01 * i;
    const Eigen::AngleAxisd turn(0.5 * q1 + 0.3, Eigen::Vector3d::UnitY());
    for (const double x : {0.0, 0.4}) {
      for (const double y : {-0.01, 0.01}) {
        for (const double z : {-0.01, 0.01}) {
          const Eigen::Vector3d p_W = Eigen::Vector3d(-0.1, 0, 0.1) + turn * Eigen::Vector3d(x, y, z);
          nearest = std::max(nearest, outside(swept, X_LW * p_W));
        }
      }
    }
  }
  EXPECT_LE(nearest, 1e-9) << "it leaves the hull";
  EXPECT_GT(nearest, -0.02) << "the hull is much too large";
}

TEST(Followers, EncloseChainsOfFollowersThatTurnAndSlide) {
  const std::string piston = rod_link("piston") + joint("jp", "prismatic", "cylinder", "piston",
                                                        R"(<axis xyz="1 0 0"/><mimic joint="j2" multiplier="-0.1"/>)");
  const auto model = load_text(robot(kArm + cylinder_on("a", R"(<mimic joint="j2"/>)") + piston));
  const LinkGeometry& swept = geometry_of(*model, "piston");
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(2), kinematics);
  const Pose X_LW = kinematics.X_WL[swept.link].inverse();
  double nearest = -INFINITY;
  for (int i = 0; i <= 400; ++i) {
    const double q2 = -2.0 + 0.01 * i;
    const Eigen::AngleAxisd turn(q2, Eigen::Vector3d::UnitY());
    const Eigen::Vector3d p_W = Eigen::Vector3d(-0.1, 0, 0.1) + turn * Eigen::Vector3d(0.4 - 0.1 * q2, 0.01, 0.01);
    nearest = std::max(nearest, outside(swept, X_LW * p_W));
  }
  EXPECT_LE(nearest, 1e-9);
  EXPECT_GT(nearest, -0.05);
}

TEST(Followers, AreNoSelfPairsOfTheLinkThatDrivesThem) {
  const auto model = load_text(robot(kArm + cylinder_on("base", R"(<mimic joint="j2"/>)")));
  for (const auto& [a, b] : model->self_pairs) {
    const std::string one = model->links[model->geometry[a].link].name;
    const std::string two = model->links[model->geometry[b].link].name;
    EXPECT_FALSE((one == "cylinder" && two == "b") || (one == "b" && two == "cylinder"));
  }
}

TEST(Followers, AreHeldWhereTheFirstPositionPutsThem) {
  const std::string limit = R"(<axis xyz="0 1 0"/><limit lower="0.2" upper="1" effort="1" velocity="1"/>)";
  const auto model = load_text(robot(ball_link("base") + rod_link("a") + joint("j1", "revolute", "base", "a", limit) +
                                     cylinder_on("base", R"(<mimic joint="j1" multiplier="-2" offset="0.1"/>)")));
  const auto held =
      std::find_if(model->links.begin(), model->links.end(), [](const Link& link) { return link.name == "cylinder"; });
  ASSERT_NE(held, model->links.end());
  const Eigen::Matrix3d turned = Eigen::AngleAxisd(-0.3, Eigen::Vector3d::UnitY()).toRotationMatrix();
  EXPECT_TRUE(held->X_PJ.linear().isApprox(turned, 1e-12));
  EXPECT_FALSE(has_note(*model, "are held")) << "it moves";
  // The hull is in the frame of the held link: its joint's origin is a corner of the swept region.
  EXPECT_LE(outside(geometry_of(*model, "cylinder"), Eigen::Vector3d::Zero()), 0.0);
}

TEST(JointsWithRanges, EncloseAllPlacesOfTheirLinks) {
  const std::string limit = R"(<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>)";
  const std::string gripper =
      rod_link("finger") + rod_link("thumb") +
      joint("grip", "prismatic", "b", "finger", R"(<origin xyz="0.4 0 0"/>)" + limit) +
      joint("thumb", "prismatic", "b", "thumb",
            R"(<origin xyz="0.4 0 0"/><axis xyz="0 1 0"/><mimic joint="grip" multiplier="-1"/>)");
  UrdfOptions options;
  options.tool_link = "b";
  options.moving_joints["grip"] = {0.1, 0.3};
  const auto model = load_text(robot(kArm + gripper), options);
  EXPECT_EQ(model->joint_names, (std::vector<std::string>{"j1", "j2"}));
  EXPECT_TRUE(has_note(*model, "follow its joints or move within their ranges"));
  Kinematics kinematics;
  forward_kinematics(*model, Pose::Identity(), JointVector::Zero(2), kinematics);
  for (const auto& [name, side] : {std::pair("finger", 1.0), std::pair("thumb", -1.0)}) {
    const LinkGeometry& swept = geometry_of(*model, name);
    const Pose X_LW = kinematics.X_WL[swept.link].inverse();
    const auto outside_at = [&](double y) { return outside(swept, X_LW * Eigen::Vector3d(1.0, side * y, 0.0)); };
    EXPECT_LE(outside_at(0.09), 0.0);
    EXPECT_LE(outside_at(0.31), 0.0);
    EXPECT_GT(outside_at(0.08), 0.0);
    EXPECT_GT(outside_at(0.32), 0.0);
  }
}

TEST(JointsWithRanges, MustBeFreeToMoveThere) {
  const std::string limit = R"(<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>)";
  const std::string arm = robot(kArm + rod_link("finger") + joint("grip", "prismatic", "b", "finger", limit));
  const auto error = [&](const std::string& name, const MotionRange& range, const std::string& base = "") {
    UrdfOptions options;
    options.base_link = base;
    options.tool_link = "b";
    options.names.held_joints = "arms[0].joints";
    options.moving_joints[name] = range;
    return test::error_of(arm, options);
  };
  EXPECT_EQ(error("grip", {-1.0, 1.0}), "");
  EXPECT_NE(error("grip", {0.0, 1.5})
                .find("r.urdf: arms[0].joints: joint 'grip' = [0, 1.5] must be within its limits, "
                      "-1 to 1"),
            std::string::npos);
  EXPECT_NE(error("grip", {0.5, 0.1}).find("must give the lower position first"), std::string::npos);
  EXPECT_NE(error("j1", {0.0, 0.1}).find("it moves the tool"), std::string::npos);
  EXPECT_NE(error("j1", {0.0, 0.1}, "a").find("joint 'j1' carries the arm and must have one position"),
            std::string::npos);
  EXPECT_NE(error("grap", {0.0, 0.1}).find("the robot has no such joint"), std::string::npos);
}

TEST(JointsWithRanges, AreAtMostTwoOfALink) {
  const std::string limit = R"(<axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>)";
  const std::string finger = rod_link("f1") + rod_link("f2") + rod_link("f3") +
                             joint("k1", "revolute", "b", "f1", limit) + joint("k2", "revolute", "f1", "f2", limit) +
                             joint("k3", "revolute", "f2", "f3", limit);
  UrdfOptions options;
  options.tool_link = "b";
  options.moving_joints = {{"k1", {0.0, 0.5}}, {"k2", {0.0, 0.5}}, {"k3", {0.0, 0.5}}};
  const std::string error = test::error_of(robot(kArm + finger), options);
  EXPECT_NE(error.find("link 'f3' moves with joints 'k1', 'k2', 'k3'; at most two may move it: give the others one "
                       "position in place of a range"),
            std::string::npos)
      << error;
}

TEST(Followers, AreRefusedFarAway) {
  EXPECT_NE(test::error_of(robot(kArm + rod_link("rod") +
                                 joint("jr", "prismatic", "base", "rod", R"(<mimic joint="j1" multiplier="1e6"/>)")))
                .find("r.urdf: link 'rod' follows a joint of the chain farther than 100 m"),
            std::string::npos);
}

TEST(Followers, NeedNoGeometry) {
  const auto model = load_text(
      robot(kArm + R"(<link name="frame"/>)" + joint("jf", "revolute", "base", "frame", R"(<mimic joint="j1"/>)")));
  EXPECT_FALSE(has_note(*model, "follow its joints"));
}

}  // namespace
}  // namespace hecaton::planner
