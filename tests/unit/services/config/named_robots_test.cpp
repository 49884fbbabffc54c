// The robots of deploy/robots: loading, poses, enclosing volumes, and kinematics against tables that are coded here
// independently of the URDFs.

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <iomanip>
#include <iostream>
#include <map>
#include <numbers>
#include <random>
#include <sstream>

#include <gtest/gtest.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/capsules.hpp"
#include "planner/model/kinematics.hpp"
#include "services/config/robot_catalogue.hpp"

namespace hecaton::config {
namespace {

using planner::JointVector;
using planner::Pose;
using planner::RobotModel;

constexpr double kPi = std::numbers::pi;
constexpr double kQuarter = kPi / 2.0;

NamedRobot named(const std::string& name) {
  planner::SourceFiles sources;
  return read_named_robot(name, sources);
}

std::shared_ptr<const RobotModel> load(const std::string& name, const std::string& tool = "") {
  planner::UrdfOptions options;
  options.tool_link = tool;
  return load_named_robot(named(name), options);
}

Pose tool_pose(const RobotModel& model, const JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(model, Pose::Identity(), q, kinematics);
  return kinematics.X_WT;
}

JointVector random_joints(const RobotModel& model, std::mt19937_64& random) {
  JointVector q(model.joints());
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double low = std::max(model.limits.lower[j], -kPi);
    q[j] = std::uniform_real_distribution<double>(low, std::min(model.limits.upper[j], kPi))(random);
  }
  return q;
}

/// The nearest distance of two shapes of the arm that the self-collision check compares [m].
double self_distance(const RobotModel& model, const JointVector& q) {
  planner::Kinematics kinematics;
  planner::forward_kinematics(model, Pose::Identity(), q, kinematics);
  double nearest = 1e9;
  for (const auto& [a, b] : model.self_pairs) {
    const planner::LinkGeometry& one = model.geometry[a];
    const planner::LinkGeometry& other = model.geometry[b];
    nearest = std::min(nearest, planner::shape_distance(one.shape, kinematics.X_WL[one.link] * one.X_LS, other.shape,
                                                        kinematics.X_WL[other.link] * other.X_LS)
                                    .distance);
  }
  return nearest;
}

/// [Denavit55] Rz(θ) Tz(d) Tx(a) Rx(α).
Pose classic(double alpha, double a, double d, double theta) {
  Pose pose = Pose::Identity();
  pose.rotate(Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ()));
  pose.translate(Eigen::Vector3d(a, 0.0, d));
  pose.rotate(Eigen::AngleAxisd(alpha, Eigen::Vector3d::UnitX()));
  return pose;
}

/// Craig's form: Rx(α) Tx(a) Rz(θ) Tz(d).
Pose modified(double alpha, double a, double d, double theta) {
  Pose pose = Pose::Identity();
  pose.rotate(Eigen::AngleAxisd(alpha, Eigen::Vector3d::UnitX()));
  pose.translate(Eigen::Vector3d(a, 0.0, 0.0));
  pose.rotate(Eigen::AngleAxisd(theta, Eigen::Vector3d::UnitZ()));
  pose.translate(Eigen::Vector3d(0.0, 0.0, d));
  return pose;
}

struct Row {
  double alpha;  ///< [rad]
  double a;      ///< [m]
  double d;      ///< [m]
  double offset = 0.0;
  double sign = 1.0;  ///< θ = sign · q + offset
};

struct DhRobot {
  std::string name;
  bool craig;
  std::vector<Row> rows;
  double flange = 0.0;       ///< along the last z [m]
  double turned_base = 0.0;  ///< of frame 0 about the x axis of the root [rad]
};

Pose flange_pose(const DhRobot& robot, const JointVector& q) {
  Pose pose = Pose::Identity();
  pose.rotate(Eigen::AngleAxisd(robot.turned_base, Eigen::Vector3d::UnitX()));
  for (std::size_t i = 0; i < robot.rows.size(); ++i) {
    const Row& row = robot.rows[i];
    const double theta = row.sign * q[static_cast<Eigen::Index>(i)] + row.offset;
    pose = pose * (robot.craig ? modified(row.alpha, row.a, row.d, theta) : classic(row.alpha, row.a, row.d, theta));
  }
  pose.translate(Eigen::Vector3d(0.0, 0.0, robot.flange));
  return pose;
}

DhRobot universal(const std::string& name, double d1, double a2, double a3, double d4, double d5, double d6) {
  return {name, false, {{kQuarter, 0, d1}, {0, a2, 0}, {0, a3, 0}, {kQuarter, 0, d4}, {-kQuarter, 0, d5}, {0, 0, d6}}};
}

DhRobot franka(const std::string& name) {
  return {name,
          true,
          {{0, 0, 0.333},
           {-kQuarter, 0, 0},
           {kQuarter, 0, 0.316},
           {kQuarter, 0.0825, 0},
           {-kQuarter, -0.0825, 0.384},
           {kQuarter, 0, 0},
           {kQuarter, 0.088, 0}},
          0.107};
}

DhRobot iiwa(const std::string& name, double shoulder, double upper_arm) {
  return {name,
          false,
          {{-kQuarter, 0, shoulder},
           {kQuarter, 0, 0},
           {kQuarter, 0, upper_arm},
           {-kQuarter, 0, 0},
           {-kQuarter, 0, 0.4},
           {kQuarter, 0, 0},
           {0, 0, 0.126}}};
}

/// Six joints with a spherical wrist: the data sheet's lengths, the makers' zero positions and senses of rotation.
DhRobot wrist_partitioned(const std::string& name, std::array<double, 6> lengths, std::array<double, 6> signs,
                          std::array<double, 6> offsets) {
  const auto [d1, a1, a2, a3, d4, d6] = lengths;
  DhRobot robot{
      name,
      true,
      {{0, 0, d1}, {-kQuarter, a1, 0}, {0, a2, 0}, {-kQuarter, a3, d4}, {kQuarter, 0, 0}, {-kQuarter, 0, d6}}};
  for (std::size_t i = 0; i < 6; ++i) {
    robot.rows[i].sign = signs[i];
    robot.rows[i].offset = offsets[i];
  }
  return robot;
}

DhRobot abb(const std::string& name, std::array<double, 6> lengths) {
  return wrist_partitioned(name, lengths, {1, 1, 1, 1, 1, 1}, {0, -kQuarter, 0, 0, 0, kPi});
}

DhRobot japanese(const std::string& name, std::array<double, 6> lengths) {
  return wrist_partitioned(name, lengths, {1, 1, -1, -1, -1, -1}, {0, -kQuarter, 0, 0, 0, 0});
}

/// xArm user manual: a₂ = 289.49 mm at 79.35° above the horizon.
constexpr double kXarmUpper = 0.28948866;
constexpr double kXarmAngle = 1.3849179;

std::vector<DhRobot> dh_robots() {
  // The forearm of the xArm 5 has no joint: it is a single length from elbow to wrist.
  const double fore = std::hypot(0.0775, 0.3425);
  const double fore_angle = std::atan2(0.3425, 0.0775);
  return {
      universal("ur3e", 0.15185, -0.24355, -0.2132, 0.13105, 0.08535, 0.0921),
      universal("ur5e", 0.1625, -0.425, -0.3922, 0.1333, 0.0997, 0.0996),
      universal("ur10e", 0.1807, -0.6127, -0.57155, 0.17415, 0.11985, 0.11655),
      universal("ur16e", 0.1807, -0.4784, -0.36, 0.17415, 0.11985, 0.11655),
      franka("panda"),
      franka("fr3"),
      iiwa("iiwa7", 0.34, 0.4),
      iiwa("iiwa14", 0.36, 0.42),
      wrist_partitioned("kr6_r900", {0.4, 0.025, 0.455, 0.035, 0.42, 0.08}, {-1, 1, 1, -1, 1, -1},
                        {0, 0, -kQuarter, 0, 0, kPi}),
      abb("irb120", {0.29, 0, 0.27, 0.07, 0.302, 0.072}),
      abb("irb1200_5_90", {0.3991, 0, 0.448, 0.042, 0.451, 0.082}),
      abb("irb1200_7_70", {0.3991, 0, 0.35, 0.042, 0.351, 0.082}),
      abb("irb2400", {0.615, 0.1, 0.705, 0.135, 0.755, 0.085}),
      japanese("m10ia", {0.45, 0.15, 0.6, 0.2, 0.64, 0.1}),
      japanese("lrmate200id", {0.33, 0.05, 0.33, 0.035, 0.335, 0.08}),
      japanese("gp7", {0.33, 0.04, 0.445, 0.04, 0.44, 0.08}),
      {"xarm5",
       true,
       {{0, 0, 0.267},
        {-kQuarter, 0, 0, -kXarmAngle},
        {0, kXarmUpper, 0, kXarmAngle + fore_angle},
        {0, fore, 0, -fore_angle},
        {-kQuarter, 0.076, 0.097}}},
      {"xarm6",
       true,
       {{0, 0, 0.267},
        {-kQuarter, 0, 0, -kXarmAngle},
        {0, kXarmUpper, 0, kXarmAngle},
        {-kQuarter, 0.0775, 0.3425},
        {kQuarter, 0, 0},
        {-kQuarter, 0.076, 0.097}}},
      {"xarm7",
       true,
       {{0, 0, 0.267},
        {-kQuarter, 0, 0},
        {kQuarter, 0, 0.293},
        {kQuarter, 0.0525, 0},
        {kQuarter, 0.0775, 0.3425},
        {kQuarter, 0, 0},
        {-kQuarter, 0.076, 0.097}}},
      {"gen3",
       false,
       {{kQuarter, 0, -0.2848},
        {kQuarter, 0, -0.0118, kPi},
        {kQuarter, 0, -0.4208, kPi},
        {kQuarter, 0, -0.0128, kPi},
        {kQuarter, 0, -0.3143, kPi},
        {kQuarter, 0, 0, kPi},
        {kPi, 0, -0.1674, kPi}},
       0.0,
       kPi},
  };
}

/// The largest errors of the flange in 200 postures.
struct FlangeError {
  double position = 0.0;  ///< [m]
  double rotation = 0.0;  ///< of the rotation matrix
};

FlangeError flange_error(const DhRobot& robot, const RobotModel& model) {
  FlangeError largest;
  std::mt19937_64 random(5);
  for (int sample = 0; sample < 200; ++sample) {
    const JointVector q = random_joints(model, random);
    const Pose expected = flange_pose(robot, q);
    const Pose found = tool_pose(model, q);
    largest.position = std::max(largest.position, (found.translation() - expected.translation()).norm());
    largest.rotation = std::max(largest.rotation, (found.linear() - expected.linear()).norm());
  }
  return largest;
}

TEST(NamedRobots, FlangeFollowsThePublishedDenavitHartenbergTable) {
  for (const DhRobot& robot : dh_robots()) {
    const auto model = load(robot.name);
    ASSERT_EQ(model->joints(), static_cast<int>(robot.rows.size())) << robot.name;
    const FlangeError error = flange_error(robot, *model);
    // The xArm manual rounds a₂ and its angle.
    EXPECT_LT(error.position, 1e-5) << robot.name;
    EXPECT_LT(error.rotation, 1e-5) << robot.name;
  }
}

TEST(NamedRobots, YumiFlangesAreWhereItsControllerHasThemAtHome) {
  // The home targets of both arms in the maker's programs [mm; w x y z]; the first frames are published with 0.1 mrad.
  struct Home {
    const char* tool;
    Eigen::Vector3d position;
    Eigen::Quaterniond rotation;
  };
  for (const Home& home : {Home{"left_tool0", {-9.578, 182.610, 198.628}, {0.066, 0.8424, -0.1112, 0.5231}},
                           Home{"right_tool0", {-9.578, -182.610, 198.628}, {0.066, -0.8424, -0.1112, -0.5231}}}) {
    const auto model = load("yumi", home.tool);
    const Pose pose = tool_pose(*model, model->named.at("home"));
    EXPECT_LT((pose.translation() - 1e-3 * home.position).norm(), 2e-3) << home.tool;
    EXPECT_LT(home.rotation.normalized().angularDistance(Eigen::Quaterniond(pose.linear())), 0.01) << home.tool;
  }
}

TEST(NamedRobots, ScaraFlangeFollowsItsArmLengths) {
  const auto model = load("irb910sc_055");
  std::mt19937_64 random(5);
  for (int sample = 0; sample < 200; ++sample) {
    const JointVector q = random_joints(*model, random);
    const Eigen::Vector3d expected(0.3 * std::cos(q[0]) + 0.25 * std::cos(q[0] + q[1]),
                                   0.3 * std::sin(q[0]) + 0.25 * std::sin(q[0] + q[1]), 0.2209 + q[2]);
    ASSERT_LT((tool_pose(*model, q).translation() - expected).norm(), 1e-9);
  }
}

TEST(NamedRobots, VariantsCarryTheArmWithTheirSlides) {
  struct Variant {
    const char* name;
    const char* arm;
    int slides;
    Eigen::Isometry3d (*base)(const JointVector& q);
  };
  const auto shifted = [](double x, double y, double z) {
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d(x, y, z);
    return pose;
  };
  static const auto move = shifted;
  const std::vector<Variant> variants = {
      {"ur10e_rail", "ur10e", 1, [](const JointVector& q) { return move(q[0], 0.0, 0.2); }},
      {"kr6_r900_rail", "kr6_r900", 1, [](const JointVector& q) { return move(0.0, q[0], 0.2); }},
      {"ur5e_gantry", "ur5e", 2, [](const JointVector& q) {
         Pose pose = move(q[0], q[1], 1.5);
         pose.rotate(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()));
         return pose;
       }}};
  for (const Variant& variant : variants) {
    const auto whole = load(variant.name);
    const auto arm = load(variant.arm);
    std::mt19937_64 random(5);
    for (int sample = 0; sample < 100; ++sample) {
      const JointVector q = random_joints(*whole, random);
      const Pose expected = variant.base(q) * tool_pose(*arm, q.tail(arm->joints()));
      ASSERT_LT((tool_pose(*whole, q).matrix() - expected.matrix()).norm(), 1e-8) << variant.name;
    }
  }
}

/// Calls `check` for every tool of every robot.
void for_every_tool(const std::function<void(const NamedRobot&, const RobotTool&, const RobotModel&)>& check) {
  const std::vector<std::string> names = robot_names();
  ASSERT_GE(names.size(), 26U);
  for (const std::string& name : names) {
    SCOPED_TRACE(name);
    const NamedRobot robot = named(name);
    for (const RobotTool& tool : robot.tools) check(robot, tool, *load(name, tool.link));
  }
}

TEST(NamedRobots, LoadWithoutNotesThatNeedAnAction) {
  for_every_tool([](const NamedRobot& robot, const RobotTool&, const RobotModel& model) {
    EXPECT_EQ(model.name, robot.name);
    for (const std::string& note : model.notes) {
      const bool expected = note.starts_with("approximate: ") ||
                            note.starts_with("joints end where links overlap in every posture") ||
                            (robot.tools.size() > 1 && note.starts_with("joints outside the chain"));
      EXPECT_TRUE(expected) << note;
    }
    EXPECT_EQ(static_cast<int>(robot.acceleration.size()), model.joints());
    EXPECT_EQ(model.limits.acceleration.size(), model.joints());
  });
}

TEST(NamedRobots, PosesAreWithinLimitsAndFreeOfSelfContact) {
  for_every_tool([](const NamedRobot&, const RobotTool& tool, const RobotModel& model) {
    EXPECT_TRUE(model.named.contains("ready"));
    for (const auto& [name, q] : model.named) {
      ASSERT_EQ(q.size(), model.joints()) << name;
      EXPECT_TRUE((q.array() >= model.limits.lower.array()).all() && (q.array() <= model.limits.upper.array()).all())
          << name << " of " << tool.link;
      EXPECT_GT(self_distance(model, q), 0.01) << name << " of " << tool.link;
      EXPECT_GT(tool_pose(model, q).translation().z(), 0.04) << name << " of " << tool.link;
    }
  });
}

/// The lowest height of a shape in the frame of its link [m].
double lowest_height(const planner::LinkGeometry& geometry) {
  const Eigen::RowVector3d z = geometry.X_LS.linear().row(2);
  const double middle = geometry.X_LS.translation().z();
  if (const auto* box = std::get_if<world::Box>(&geometry.shape)) {
    return middle - z.cwiseAbs().dot(box->half_extents.transpose());
  }
  if (const auto* cylinder = std::get_if<world::Cylinder>(&geometry.shape)) {
    return middle - cylinder->half_length * std::abs(z[2]) - cylinder->radius * std::hypot(z[0], z[1]);
  }
  const auto& capsule = std::get<world::Capsule>(geometry.shape);
  return middle - capsule.half_length * std::abs(z[2]) - capsule.radius;
}

TEST(NamedRobots, StandOnTheirMountingPlane) {
  for_every_tool([](const NamedRobot& robot, const RobotTool&, const RobotModel& model) {
    // The controller of the YuMi has its base frame 0.1 m above the plane.
    const double plane = robot.name == "yumi" ? -0.1 : 0.0;
    for (const planner::LinkGeometry& geometry : model.geometry) {
      if (geometry.link != 0) continue;
      EXPECT_GT(lowest_height(geometry), plane - 1e-6);
    }
  });
}

/// What is known of the outline of a robot.
struct Outline {
  double mass;    ///< of the data sheet [kg]
  double litres;  ///< of our shapes
  double hulls;   ///< our shapes ÷ the convex hulls of the links of the public 3D model; 1: not measured
};

const std::map<std::string, Outline>& outlines() {
  static const std::map<std::string, Outline> all = {
      {"ur3e", {11.2, 10.21, 1.11}},       {"ur5e", {20.6, 20.46, 1.04}},         {"ur10e", {33.5, 40.90, 1.10}},
      {"ur16e", {33.1, 34.82, 1.09}},      {"panda", {17.8, 26.72, 1.23}},        {"fr3", {17.8, 26.72, 1.23}},
      {"iiwa7", {23.9, 35.88, 1.36}},      {"iiwa14", {29.9, 43.96, 1.41}},       {"kr6_r900", {52.0, 75.97, 1.24}},
      {"irb120", {25.0, 40.65, 1.33}},     {"m10ia", {130.0, 122.7, 1.54}},       {"gp7", {34.0, 58.74, 1.50}},
      {"xarm5", {11.2, 18.54, 1.19}},      {"irb1200_5_90", {54.0, 78.21, 1.41}}, {"irb1200_7_70", {52.0, 78.44, 1.38}},
      {"irb2400", {380.0, 526.3, 1.57}},   {"xarm6", {12.2, 15.71, 1.12}},        {"xarm7", {13.7, 15.29, 1.18}},
      {"gen3", {8.2, 10.93, 1.33}},        {"lrmate200id", {25.0, 48.69, 1.47}},  {"yumi", {38.0, 78.78, 1.0}},
      {"irb910sc_055", {24.5, 32.57, 1.0}}};
  return all;
}

double litres_of(const RobotModel& model) {
  double volume = 0.0;
  for (const planner::LinkGeometry& geometry : model.geometry) volume += planner::volume(geometry.shape);
  return 1e3 * volume;
}

// A shape of twice the size has half the density, which the band excludes.
TEST(NamedRobots, EnclosingVolumesFitTheMassesOfTheRobots) {
  for (const auto& [name, outline] : outlines()) {
    const double litres = litres_of(*load(name));
    EXPECT_NEAR(litres, outline.litres, 0.01 * outline.litres) << name;
    // Arms of aluminium with motors, gears and air. The M-10iA is heavier, the body of the YuMi is mostly air.
    const double density = outline.mass / litres * outline.hulls;
    const bool heavy = name == "m10ia";
    const bool light = name == "yumi";
    EXPECT_GT(density, heavy ? 1.4 : light ? 0.43 : 0.7) << name << ": " << litres << " l are too much";
    EXPECT_LT(density, heavy ? 1.8 : light ? 0.54 : 1.3) << name << ": " << litres << " l are too little";
  }
}

/// In 20,000 postures [m].
double farthest_from_axis_1(const RobotModel& model, int link) {
  std::mt19937_64 random(5);
  planner::Kinematics kinematics;
  double farthest = 0.0;
  for (int sample = 0; sample < 20000; ++sample) {
    planner::forward_kinematics(model, Pose::Identity(), random_joints(model, random), kinematics);
    farthest = std::max(farthest, kinematics.X_WL[link].translation().head<2>().norm());
  }
  return farthest;
}

TEST(NamedRobots, ReachAgreesWithWhatTheMakerPublishes) {
  // Makers measure to the wrist or to the flange, from axis 1 or from the shoulder: the published reach lies between
  // the largest distance of the wrist from axis 1 and the length of the whole arm.
  for (const std::string& name : robot_names()) {
    const NamedRobot robot = named(name);
    const auto model = load(name);
    const bool carried = model->links[1].joint_type == planner::JointType::kPrismatic;
    if (carried || robot.tools.size() > 1) continue;
    planner::Arm arm;
    arm.model = model;
    arm.limits = model->limits;
    EXPECT_GT(planner::arm_reach(arm).tool, 0.99 * robot.reach) << name;
    // The origin of the last joint but one: the wrist.
    int wrist = 0;
    for (int link = 0; link < static_cast<int>(model->links.size()); ++link) {
      if (model->links[link].joint == model->joints() - 2) wrist = link;
    }
    const double farthest = farthest_from_axis_1(*model, wrist);
    EXPECT_LT(farthest, 1.03 * robot.reach) << name;
    EXPECT_GT(farthest, 0.75 * robot.reach) << name;
  }
}

// The figures in docs/data/robot_shapes.csv: `test_config --gtest_filter='*ListsErrors*'`.
TEST(NamedRobots, ListsErrorsAgainstPublishedValues) {
  std::map<std::string, DhRobot> tables;
  for (const DhRobot& robot : dh_robots()) tables.emplace(robot.name, robot);
  std::size_t rows = 0;
  for (const auto& [name, outline] : outlines()) {
    const NamedRobot robot = named(name);
    const auto model = load(name);
    std::ostringstream row;
    row << std::fixed << "| `" << name << "` | ";
    if (const auto table = tables.find(name); table != tables.end()) {
      const FlangeError error = flange_error(table->second, *model);
      row << std::setprecision(1) << 1e6 * error.position << ", " << 1e6 * error.rotation;
    }
    const double flange = farthest_from_axis_1(*model, model->tool_link);
    const double litres = litres_of(*model);
    row << std::setprecision(2) << " | " << robot.reach << ", " << flange << " | " << std::setprecision(1) << litres
        << " | ";
    if (outline.hulls != 1.0) row << std::setprecision(2) << outline.hulls;
    row << " | " << std::setprecision(2) << outline.mass / litres * outline.hulls << " |";
    std::cout << row.str() << "\n";
    ++rows;
  }
  EXPECT_EQ(rows, outlines().size());
}

}  // namespace
}  // namespace hecaton::config
