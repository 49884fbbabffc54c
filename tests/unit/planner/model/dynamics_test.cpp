// The forces that a motion takes, against a textbook's arm and against the energy of the URDF's own links.
#include "planner/model/dynamics.hpp"

#include <cmath>
#include <random>

#include "planner/model/kinematics.hpp"
#include "tests/unit/planner/model/support.hpp"

namespace hecaton::planner {
namespace {

using test::joint;
using test::load_text;
using test::robot;

constexpr double kG = 9.80665;  // [m/s²]
const Eigen::Vector3d kGravity(0.0, 0.0, -kG);

std::string link(const std::string& name, const std::string& inertial) {
  return "<link name=\"" + name + "\"><collision><geometry><sphere radius=\"0.05\"/></geometry></collision>" +
         inertial + "</link>";
}

std::string inertial(double mass, const std::string& xyz, const std::string& inertia = "ixx='0' iyy='0' izz='0'",
                     const std::string& rpy = "0 0 0") {
  return "<inertial><origin xyz=\"" + xyz + "\" rpy=\"" + rpy + "\"/><mass value=\"" + std::to_string(mass) +
         "\"/><inertia ixy='0' ixz='0' iyz='0' " + inertia + "/></inertial>";
}

std::string limit(double effort) {
  return "<limit lower=\"-2\" upper=\"2\" effort=\"" + std::to_string(effort) + "\" velocity=\"1.5\"/>";
}

// Two links in a vertical plane, each with a mass at its end; positive joints lift. l₁ = 0.5 m, l₂ = 0.3 m.
const std::string kTwoLinks = robot(
    link("base", "") + link("upper", inertial(4.0, "0.5 0 0")) + link("lower", inertial(2.0, "0.3 0 0")) +
    joint("shoulder", "revolute", "base", "upper", "<axis xyz=\"0 -1 0\"/>" + limit(80.0)) +
    joint("elbow", "revolute", "upper", "lower", "<origin xyz=\"0.5 0 0\"/><axis xyz=\"0 -1 0\"/>" + limit(20.0)));

TEST(Dynamics, IsThatOfTwoLinksOfATextbook) {
  const auto model = load_text(kTwoLinks);
  ASSERT_EQ(why_no_forces(*model), "");
  EXPECT_EQ(model->masses->effort, (JointVector(2) << 80.0, 20.0).finished());
  // Held level: (4 · 0.5 + 2 · 0.8) g and 2 · 0.3 g.
  const JointVector level =
      inverse_dynamics(*model, kGravity, JointVector::Zero(2), JointVector::Zero(2), JointVector::Zero(2));
  EXPECT_NEAR(level[0], 3.6 * kG, 1e-12);
  EXPECT_NEAR(level[1], 0.6 * kG, 1e-12);

  // [Craig05] equation 6.58, point masses at the ends of the links.
  const double m1 = 4.0, m2 = 2.0, l1 = 0.5, l2 = 0.3;
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> draw(-2.0, 2.0);
  for (int trial = 0; trial < 200; ++trial) {
    const JointVector q = JointVector::NullaryExpr(2, [&] { return draw(random); });
    const JointVector v = JointVector::NullaryExpr(2, [&] { return draw(random); });
    const JointVector a = JointVector::NullaryExpr(2, [&] { return draw(random); });
    const double c2 = std::cos(q[1]), s2 = std::sin(q[1]), c1 = std::cos(q[0]), c12 = std::cos(q[0] + q[1]);
    const double shoulder = m2 * l2 * l2 * (a[0] + a[1]) + m2 * l1 * l2 * c2 * (2.0 * a[0] + a[1]) +
                            (m1 + m2) * l1 * l1 * a[0] - m2 * l1 * l2 * s2 * (v[1] * v[1] + 2.0 * v[0] * v[1]) +
                            m2 * l2 * kG * c12 + (m1 + m2) * l1 * kG * c1;
    const double elbow =
        m2 * l1 * l2 * c2 * a[0] + m2 * l1 * l2 * s2 * v[0] * v[0] + m2 * l2 * kG * c12 + m2 * l2 * l2 * (a[0] + a[1]);
    const JointVector forces = inverse_dynamics(*model, kGravity, q, v, a);
    ASSERT_NEAR(forces[0], shoulder, 1e-9) << trial;
    ASSERT_NEAR(forces[1], elbow, 1e-9) << trial;
  }
}

/// A link of the URDF below, as the file gives it.
struct GivenMass {
  const char* link;
  double mass;
  Pose X_LI;
  Eigen::Vector3d inertia;  ///< principal, about the centre of mass [kg m²]
};

// A rail, a turning shoulder, an elbow, a wrist that follows the elbow, and a flange fixed to it.
const std::vector<GivenMass> kGiven{
    {"carriage", 9.0, world::pose_from_xyz_rpy({0.1, 0.02, 0.0}, {0.1, 0.0, 0.2}), {0.2, 0.3, 0.4}},
    {"upper", 5.0, world::pose_from_xyz_rpy({0.0, 0.1, 0.2}, {0.4, 0.3, 0.0}), {0.08, 0.02, 0.07}},
    {"lower", 3.0, world::pose_from_xyz_rpy({0.2, 0.0, 0.01}, {0.0, 0.7, 0.1}), {0.01, 0.05, 0.04}},
    {"wrist", 1.5, world::pose_from_xyz_rpy({0.0, -0.05, 0.03}, {0.2, 0.0, 0.9}), {0.004, 0.003, 0.002}},
    {"flange", 0.7, world::pose_from_xyz_rpy({0.02, 0.0, 0.06}, {0.0, 0.5, 0.0}), {0.001, 0.002, 0.0015}},
};
const std::string kRail = robot(
    link("base", "") + link("carriage", inertial(9.0, "0.1 0.02 0", "ixx='0.2' iyy='0.3' izz='0.4'", "0.1 0 0.2")) +
    link("upper", inertial(5.0, "0 0.1 0.2", "ixx='0.08' iyy='0.02' izz='0.07'", "0.4 0.3 0")) +
    link("lower", inertial(3.0, "0.2 0 0.01", "ixx='0.01' iyy='0.05' izz='0.04'", "0 0.7 0.1")) +
    link("wrist", inertial(1.5, "0 -0.05 0.03", "ixx='0.004' iyy='0.003' izz='0.002'", "0.2 0 0.9")) +
    link("flange", inertial(0.7, "0.02 0 0.06", "ixx='0.001' iyy='0.002' izz='0.0015'", "0 0.5 0")) +
    joint("rail", "prismatic", "base", "carriage", "<axis xyz=\"1 0.3 0.5\"/>" + limit(900.0)) +
    joint("shoulder", "revolute", "carriage", "upper",
          "<origin xyz=\"0 0.1 0.4\" rpy=\"0.2 0 0\"/><axis xyz=\"0 0 1\"/>" + limit(80.0)) +
    joint("elbow", "revolute", "upper", "lower",
          "<origin xyz=\"0.1 0 0.3\" rpy=\"0 0.4 0.1\"/><axis xyz=\"0 1 0.2\"/>" + limit(50.0)) +
    joint("wrist_joint", "revolute", "lower", "wrist",
          "<origin xyz=\"0.4 0 0\" rpy=\"0.5 0 0\"/><axis xyz=\"1 0 0\"/><limit lower=\"-4\" upper=\"4\" effort=\"9\" "
          "velocity=\"9\"/><mimic joint=\"elbow\" multiplier=\"-1.5\" offset=\"0.2\"/>") +
    joint("flange_joint", "fixed", "wrist", "flange", "<origin xyz=\"0 0 0.1\" rpy=\"0 0.2 0\"/>"));

/// Kinetic and potential energy of the file's links [J], from the Jacobians of the planner.
double energy(const RobotModel& model, const JointVector& q, const JointVector& v) {
  Kinematics at;
  forward_kinematics(model, Pose::Identity(), q, at);
  double sum = 0.0;
  for (const GivenMass& given : kGiven) {
    int index = 0;
    while (model.links[index].name != given.link) ++index;
    const Pose X_WI = at.X_WL[index] * given.X_LI;
    const auto velocity = [&](const Eigen::Vector3d& p_W) -> Eigen::Vector3d {
      PointJacobian J;
      point_jacobian(model, at, index, p_W, J);
      return J * v;
    };
    const Eigen::Vector3d centre = velocity(X_WI.translation());
    // The rigid body's ω, from how its unit axes move: ω = ½ Σ e × ė.
    Eigen::Vector3d omega = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = X_WI.linear().col(k);
      omega += 0.5 * e.cross(velocity(X_WI.translation() + e) - centre);
    }
    const Eigen::Vector3d omega_I = X_WI.linear().transpose() * omega;
    sum += 0.5 * given.mass * centre.squaredNorm() + 0.5 * omega_I.dot(given.inertia.asDiagonal() * omega_I) +
           given.mass * kG * X_WI.translation().z();
  }
  return sum;
}

TEST(Dynamics, GivesThePowerThatChangesTheEnergyOfAllLinks) {
  const auto model = load_text(kRail);
  ASSERT_EQ(model->joints(), 3);
  ASSERT_EQ(why_no_forces(*model), "");
  EXPECT_NEAR(model->masses->bodies.back().mass, 2.2, 1e-12) << "the flange counts with the wrist";
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  constexpr double h = 1e-5;  // [s]
  for (int trial = 0; trial < 500; ++trial) {
    const JointVector q = JointVector::NullaryExpr(3, [&] { return draw(random); });
    const JointVector v = JointVector::NullaryExpr(3, [&] { return draw(random); });
    const JointVector a = JointVector::NullaryExpr(3, [&] { return 5.0 * draw(random); });
    const auto later = [&](double t) { return energy(*model, q + v * t + 0.5 * t * t * a, v + a * t); };
    const double power = (later(h) - later(-h)) / (2.0 * h);
    ASSERT_NEAR(inverse_dynamics(*model, kGravity, q, v, a).dot(v), power, 1e-5) << trial;
  }
}

TEST(Dynamics, SaysWhichMassOrLimitIsMissing) {
  const auto without = load_text(
      robot(test::ball_link("base") + test::ball_link("arm") + joint("turn", "revolute", "base", "arm", limit(5.0))));
  EXPECT_EQ(why_no_forces(*without), "link arm has no mass in the robot description (<inertial>)");
  const auto unlimited = load_text(robot(test::ball_link("base") + link("arm", inertial(1.0, "0 0 0")) +
                                         joint("turn", "revolute", "base", "arm", limit(0.0))));
  EXPECT_EQ(why_no_forces(*unlimited), "joint turn has no effort limit in the robot description (<limit effort=…>)");
  EXPECT_EQ(why_no_forces(RobotModel()), "the robot description has no masses");
}

TEST(Dynamics, LeavesOutAnInertialThatIsNoNumberYet) {
  std::string urdf = robot(test::ball_link("base") + link("arm", inertial(1.0, "0 0 0")) +
                           joint("turn", "revolute", "base", "arm", limit(5.0)));
  urdf.replace(urdf.find("1.000000"), 8, "${mass}");
  EXPECT_EQ(why_no_forces(*load_text(urdf)), "link arm has no mass in the robot description (<inertial>)");
}

}  // namespace
}  // namespace hecaton::planner
