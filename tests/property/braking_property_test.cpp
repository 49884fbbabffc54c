// Braking before contact (docs/explanation/0001-braking.md, 0010-passing-obstacles.md): arms move among bodies under
// the real tick. From every tick the stop profile is simulated to rest, with exact distances.
#include <algorithm>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/collision/exact_distance.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/config/cell_file.hpp"
#include "tests/unit/planner/collision/random_shapes.hpp"

namespace hecaton::planner {
namespace {

using test::Kind;
using test::uniform;

constexpr double kPeriod = 0.01;   // [s]
constexpr double kStep = 0.001;    // of a stop beside things that move [s]
constexpr double kSight = 0.5;     // how far distances are measured [m]
constexpr double kContact = 1e-5;  // distances of hulls are that exact [m]

/// A chain of links of every shape, slender enough to avoid self-collision.
Arm slender_arm(const std::string& name, int joints, test::Random& random) {
  auto model = std::make_shared<RobotModel>();
  model->name = name;
  model->links.emplace_back().name = "root";
  double length = 0.0;
  for (int i = 0; i < joints; ++i) {
    Link link;
    link.name = "link" + std::to_string(i + 1);
    link.joint_name = "joint" + std::to_string(i + 1);
    link.parent = link.joint = i;
    link.joint_type = JointType::kRevolute;
    link.X_PJ.translation().z() = length;
    link.axis = test::random_direction(random);
    model->links.push_back(link);
    model->joint_names.push_back(link.joint_name);
    length = uniform(random, 0.2, 0.4);
    const double radius = uniform(random, 0.02, 0.04);
    const double half = 0.5 * length - radius;
    world::Shape shape = world::Capsule{radius, half};
    if (i % 4 == 1) shape = world::Cylinder{radius, half};
    if (i % 4 == 2) shape = world::Box{{radius, 0.7 * radius, half}};
    if (i % 4 == 3) shape = test::prism(7, radius, half, Eigen::Vector3d::Zero());
    const auto capsule = link_capsule(shape);
    Pose X_LS = Pose::Identity();
    X_LS.translation().z() = 0.5 * length;
    model->geometry.push_back({i + 1, std::move(shape), X_LS, 0.0, capsule});
  }
  model->tool_link = joints;
  for (int first = 0; first < joints; ++first) {
    for (int second = first + 2; second < joints; ++second) model->self_pairs.emplace_back(first, second);
  }
  model->limits.lower.setConstant(joints, -2.8);
  model->limits.upper.setConstant(joints, 2.8);
  Arm arm;
  arm.name = name;
  arm.model = model;
  arm.limits = model->limits;
  arm.named["home"] = JointVector::Zero(joints);
  return arm;
}

struct Setting {
  std::vector<Arm> arms;
  DamperParameters damper;
  int things = 10;
  double fastest_thing = 0.0;  ///< [m/s]; 0: all bodies are static
};

struct Tally {
  long stops = 0;
  long relaxed = 0;
  long near = 0;          ///< stops that began with a body within dᵢ
  long touched = 0;       ///< stops that touched a static body, the own arm, or an arm that stops at the same time
  long driven_into = 0;   ///< stops, not from relaxed ticks, that touched a moving body while the arm approached it
  double nearest = 10.0;  ///< least distance from static bodies during any stop [m]
};

class Drive {
 public:
  Drive(const Setting& setting, std::uint64_t seed) : setting_(setting), random_(seed) {
    parameters_.damper = setting.damper;
    parameters_.rollout.candidates = 0;
    parameters_.replanning.stall_timeout = 0.0;
    for (int i = 0; i < setting.things; ++i) place_thing(i);
    for (int i = 0; i < arms(); ++i) {
      geometries_.emplace_back(setting.arms, i);
      geometries_.back().set_obstacles(things_);
      distances_.emplace_back(geometries_.back());
    }
    for (const CellGeometry& geometry : geometries_) {
      controllers_.emplace_back(geometry, parameters_, kPeriod, random_());
      controllers_.back().set_obstacles(things_);
    }
    kinematics_.resize(arms());
  }

  /// Places all arms free of contacts; false if no such positions were found.
  bool begin() {
    for (int attempt = 0; attempt < 2000; ++attempt) {
      at_.clear();
      for (int i = 0; i < arms(); ++i) at_.push_back({somewhere(i), JointVector::Zero(joints(i))});
      bool clear = true;
      for (int i = 0; i < arms() && clear; ++i) clear = clear_at_start(i);
      if (clear) return true;
    }
    return false;
  }

  void drive(double seconds, Tally& tally) {
    for (int i = 0; i < arms(); ++i) controllers_[i].set_goal(somewhere(i));
    for (double now = 0.0; now < seconds; now += kPeriod) {
      std::vector<ArmObservation> seen;
      for (int i = 0; i < arms(); ++i) seen.push_back({at_[i].q, at_[i].qd, 0.0, true, true});
      bool relaxed = false;
      for (int i = 0; i < arms(); ++i) {
        const TickResult result = controllers_[i].step(at_[i], seen, states_, false);
        at_[i] = {result.q, result.qd};
        relaxed = relaxed || result.relaxed;
        tally.near += result.near ? 1 : 0;
        if (result.status == TickStatus::kReached || uniform(random_, 0.0, 1.0) < 0.005) {
          controllers_[i].set_goal(somewhere(i));
        }
      }
      for (world::ObstacleState& state : states_) {
        state.X_WO = world::extrapolate(state.X_WO, state.velocity, kPeriod);
      }
      turn_back();
      ++tally.stops;
      tally.relaxed += relaxed ? 1 : 0;
      const double nearest = nearest_in_stop();
      tally.nearest = std::min(tally.nearest, nearest);
      tally.touched += nearest < -kContact ? 1 : 0;
      if (setting_.fastest_thing > 0.0 && !relaxed && runs_into_what_moves()) ++tally.driven_into;
    }
  }

 private:
  [[nodiscard]] int arms() const { return static_cast<int>(setting_.arms.size()); }
  [[nodiscard]] int joints(int i) const { return static_cast<int>(setting_.arms[i].limits.lower.size()); }
  [[nodiscard]] bool moves(int thing) const { return !states_[thing].velocity.linear.isZero(); }

  JointVector somewhere(int i) {
    const JointLimits& limits = setting_.arms[i].limits;
    JointVector q = limits.lower;
    for (int j = 0; j < q.size(); ++j) {
      q[j] = uniform(random_, std::max(-3.0, limits.lower[j]), std::min(3.0, limits.upper[j]));
    }
    return q;
  }

  /// Bodies of every kind within reach; every second one moves if any does.
  void place_thing(int i) {
    world::Obstacle& thing = things_.emplace_back();
    thing.name = "thing" + std::to_string(i);
    thing.shapes.push_back({test::random_shape(static_cast<Kind>(i % test::kKinds), random_), Pose::Identity()});
    thing.X_WO = test::random_pose(random_, 1.0);
    world::ObstacleState& state = states_.emplace_back();
    state.X_WO = thing.X_WO;
    if (setting_.fastest_thing > 0.0 && i % 2 == 0) {
      state.velocity.linear = uniform(random_, 0.05, setting_.fastest_thing) * test::random_direction(random_);
    }
  }

  /// Replaces bodies that have left, out of reach: no body changes its velocity near an arm.
  void turn_back() {
    for (world::ObstacleState& state : states_) {
      const Eigen::Vector3d& p = state.X_WO.translation();
      const Eigen::Vector3d& v = state.velocity.linear;
      if (v.isZero() || p.norm() < 2.5 || p.dot(v) < 0.0) continue;
      state.X_WO.translation() = -2.5 * (v + 0.3 * v.norm() * test::random_direction(random_)).normalized();
    }
  }

  std::span<const Clearance> clearances(int i, const std::vector<MeasuredState>& at,
                                        std::span<const world::ObstacleState> states) {
    for (int k = 0; k < arms(); ++k) {
      forward_kinematics(*setting_.arms[k].model, setting_.arms[k].X_WB, at[k].q, kinematics_[k]);
    }
    const CellPoses poses{&kinematics_[i], kinematics_, states};
    const int count = distances_[i].clearances(poses, {.others = kSight, .self = kSight}, near_);
    return std::span(near_).first(count);
  }

  bool clear_at_start(int i) {
    for (const Clearance& c : clearances(i, at_, states_)) {
      const bool self = c.counterpart == Counterpart::kSelf;
      const double security = self ? setting_.damper.self_security_distance : setting_.damper.security_distance;
      if (c.distance < security + (self ? 0.0 : 0.03)) return false;
    }
    return true;
  }

  /// Bound of the speed of any point of the arm during its stop [m/s].
  [[nodiscard]] double fastest_point(int i, const JointVector& qd) const {
    return 2.0 * geometries_[i].arm_reach(i).radius * qd.cwiseAbs().sum();
  }

  /// All arms stop at once. Steps are short enough that no pair can touch in between.
  double nearest_in_stop() {
    double nearest = kSight;
    std::vector<MeasuredState> now = at_;
    double longest = 0.0;
    for (int i = 0; i < arms(); ++i) longest = std::max(longest, stop_time(setting_.arms[i].limits, at_[i].qd));
    for (double t = 0.0;;) {
      double wait = longest;
      for (int i = 0; i < arms(); ++i) {
        double d = kSight;
        for (const Clearance& c : clearances(i, now, states_)) {
          if (c.counterpart != Counterpart::kObstacle || !moves(c.other)) d = std::min(d, c.distance);
        }
        nearest = std::min(nearest, d);
        double speed = 2.0 * fastest_point(i, now[i].qd);  // links of one arm move both
        for (int k = 0; k < arms(); ++k) speed += k == i ? 0.0 : fastest_point(k, now[k].qd);
        if (speed > 0.0) wait = std::min(wait, std::max(d, 0.002) / speed);
      }
      if (nearest < -kContact || t >= longest) return nearest;
      wait = std::min(std::max(wait, 1e-4), longest - t + 1e-9);
      t += wait;
      now = at_;
      for (int i = 0; i < arms(); ++i) stop_for(setting_.arms[i].limits, t, now[i].q, now[i].qd);
    }
  }

  /// The stop of the first arm among moving bodies: true if the arm approaches the body that it touches first.
  bool runs_into_what_moves() {
    const Arm& arm = setting_.arms[0];
    const double longest = stop_time(arm.limits, at_[0].qd);
    std::vector<MeasuredState> now = at_;
    std::vector<world::ObstacleState> states = states_;
    for (double t = 0.0; t <= longest; t += kStep) {
      now[0] = at_[0];
      stop_for(arm.limits, t, now[0].q, now[0].qd);
      for (std::size_t k = 0; k < states.size(); ++k) {
        states[k].X_WO = world::extrapolate(states_[k].X_WO, states_[k].velocity, t);
      }
      for (const Clearance& c : clearances(0, now, states)) {
        if (c.counterpart != Counterpart::kObstacle || !moves(c.other) || c.distance > 0.0) continue;
        if (t == 0.0) return false;  // it is being run over already
        JointVector g;
        directional_jacobian(*arm.model, kinematics_[0], c.own_link, c.p_own_W, c.n_W, g);
        return g.dot(now[0].qd) > 1e-3;
      }
    }
    return false;
  }

  Setting setting_;
  test::Random random_;
  LocalParameters parameters_;
  std::vector<world::Obstacle> things_;
  std::vector<world::ObstacleState> states_;
  std::vector<CellGeometry> geometries_;
  std::vector<ExactDistance> distances_;
  std::vector<ArmController> controllers_;
  std::vector<MeasuredState> at_;
  std::vector<Kinematics> kinematics_;
  std::array<Clearance, 512> near_;
};

/// Three dampers: one that arms of 1.5 rad/s can follow by braking, the default, and one steeper than any arm can
/// brake.
const DamperParameters kDampers[] = {
    {.influence_distance = 0.12, .security_distance = 0.03, .convergence_speed = 0.55},
    {},
    {.influence_distance = 0.08, .security_distance = 0.02, .convergence_speed = 1.5},
};

void set_limits(Arm& arm, int trial) {
  constexpr double kSpeeds[] = {0.5, 1.5, 3.0};
  constexpr double kStops[] = {0.1, 0.25, 0.5};  // the longest stop [s]
  arm.limits.velocity.setConstant(arm.limits.lower.size(), kSpeeds[trial % 3]);
  arm.limits.acceleration = arm.limits.velocity / kStops[trial / 3 % 3];
}

/// Drives `arms_of(random)` with every damper and limit.
template <typename ArmsOf>
Tally drive_all(const ArmsOf& arms_of, int things, double fastest_thing, int trials, std::uint64_t seed) {
  test::Random random(seed);
  Tally tally;
  for (int trial = 0; trial < trials; ++trial) {
    Setting setting{arms_of(random), kDampers[trial / 9 % 3], things, fastest_thing};
    for (Arm& arm : setting.arms) set_limits(arm, trial);
    Drive drive(setting, random());
    if (drive.begin()) drive.drive(6.0, tally);
  }
  std::printf("%ld stops, %ld near, %ld relaxed, %ld touched, %ld driven into, nearest %.1f mm\n", tally.stops,
              tally.near, tally.relaxed, tally.touched, tally.driven_into, 1e3 * tally.nearest);
  EXPECT_GT(tally.stops, trials * 300L) << "or nothing was tried";
  EXPECT_GT(tally.near, tally.stops / 20);
  EXPECT_EQ(tally.touched, 0);
  EXPECT_EQ(tally.driven_into, 0);
  return tally;
}

std::vector<Arm> puma(test::Random&) {
  static const Arm arm = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/three_puma.yaml").cell.arms[0].arm;
  Arm alone = arm;
  alone.X_WB = Pose::Identity();
  return {alone};
}

std::vector<Arm> random_arm(test::Random& random) {
  return {slender_arm("random", std::uniform_int_distribution<int>(2, 7)(random), random)};
}

std::vector<Arm> two_arms(test::Random& random) {
  std::vector<Arm> both = {random_arm(random)[0], random_arm(random)[0]};
  both[1].name = "other";
  both[1].X_WB.translation() = Eigen::Vector3d(uniform(random, 0.4, 0.9), 0.0, 0.0);
  return both;
}

TEST(BrakingProperty, PumaStopsBeforeStaticObstacles) {
  drive_all(puma, 10, 0.0, 27, 1);
}

TEST(BrakingProperty, RandomArmsStopBeforeStaticObstacles) {
  drive_all(random_arm, 8, 0.0, 54, 2);
}

TEST(BrakingProperty, TwoArmsThatStopTogetherTouchNothing) {
  drive_all(two_arms, 4, 0.0, 54, 3);
}

TEST(BrakingProperty, ArmNeverRunsIntoObstacleAtConstantVelocity) {
  drive_all(puma, 6, 0.6, 27, 4);
  drive_all(random_arm, 8, 0.6, 54, 5);
}

}  // namespace
}  // namespace hecaton::planner
