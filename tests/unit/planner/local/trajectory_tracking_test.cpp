#include "planner/local/trajectory_tracking.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/local/random.hpp"
#include "planner/trajectory/time_optimal.hpp"
#include "tests/support/planar_point.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::planner {
namespace {

using test::joints;
using test::kPeriod;

/// From (−1, 0) to (1, 0) on a trapezoid of 0.4 m/s and 2 m/s², sampled each 0.1 s as MoveIt does. `bend`: a bow in y.
TimedTrajectory trapezoid(bool velocities, bool accelerations = false, double bend = 0.0) {
  constexpr double kSpeed = 0.4, kAcceleration = 2.0, kWay = 2.0;
  constexpr double kRamp = kSpeed / kAcceleration, kDuration = kWay / kSpeed + kRamp;
  TimedTrajectory trajectory;
  for (int i = 0; i <= 52; ++i) {
    const double t = kDuration * i / 52;
    double s = kSpeed * (t - 0.5 * kRamp), v = kSpeed, a = 0.0;
    if (t < kRamp) s = 0.5 * kAcceleration * t * t, v = kAcceleration * t, a = kAcceleration;
    if (const double left = kDuration - t; left < kRamp)
      s = kWay - 0.5 * kAcceleration * left * left, v = kAcceleration * left, a = -kAcceleration;
    TimedPoint point{t, joints({s - 1.0, bend * std::sin(M_PI * s)}), {}, {}};
    if (velocities) point.qd = joints({v, bend * M_PI * std::cos(M_PI * s) * v});
    if (accelerations) {
      point.qdd = joints({a, bend * M_PI * (std::cos(M_PI * s) * a - M_PI * std::sin(M_PI * s) * v * v)});
    }
    trajectory.points.push_back(point);
  }
  return trajectory;
}

/// One arm on its trajectory, whose drive follows at once.
class TrackingArm {
 public:
  explicit TrackingArm(std::vector<world::Obstacle> boxes = {}) : boxes_(std::move(boxes)) {
    controller_.emplace(CellGeometry({test::planar_point()}, 0), LocalParameters{}, kPeriod, 3);
    set_obstacles(boxes_);
  }
  void set_obstacles(std::vector<world::Obstacle> boxes) {
    boxes_ = std::move(boxes);
    states_.clear();
    for (const auto& box : boxes_) states_.push_back({box.X_WO, {}, 0.0});
    controller_->set_obstacles(boxes_);
  }
  void start(TimedTrajectory trajectory, double time = 0.0) {
    const JointVector end = trajectory.end();
    if (measured_.q.size() == 0) measured_ = {trajectory.points.front().q, joints({0, 0})};
    controller_->set_goal(end, std::make_shared<const TimedTrajectory>(std::move(trajectory)), time);
  }
  TickResult step(bool hold = false) {
    const std::vector<ArmObservation> arms(1);
    const double before = tracking().time;
    const TickResult result = controller_->step(measured_, arms, states_, hold);
    measured_ = {result.q, result.qd};
    elapsed_ += kPeriod;
    time_falls_ = time_falls_ || tracking().time < before;
    if (tracking().trajectory && tracking().follows())
      worst_ = std::max(worst_, (tracking().at(tracking().time).q - result.q).cwiseAbs().maxCoeff());
    return result;
  }
  /// The time until it has reached the end [s]; infinite: not within `limit`.
  double drive(double limit) {
    while (elapsed_ < limit) {
      if (step().status == TickStatus::kReached) return elapsed_;
    }
    return std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] const TrajectoryTracking& tracking() const { return controller_->memory().tracking; }
  [[nodiscard]] ArmController& controller() { return *controller_; }
  [[nodiscard]] const MeasuredState& measured() const { return measured_; }
  void place(const JointVector& q, const JointVector& qd) { measured_ = {q, qd}; }
  [[nodiscard]] double worst() const { return worst_; }
  [[nodiscard]] bool time_falls() const { return time_falls_; }

 private:
  std::vector<world::Obstacle> boxes_;
  std::vector<world::ObstacleState> states_;
  std::optional<ArmController> controller_;
  MeasuredState measured_;
  double elapsed_ = 0.0;
  double worst_ = 0.0;
  bool time_falls_ = false;
};

TEST(TrajectoryTracking, FollowsATrajectoryInItsTime) {
  for (const bool accelerations : {false, true}) {
    TrackingArm arm;
    const TimedTrajectory trajectory = trapezoid(true, accelerations, 0.05);
    arm.start(trajectory);
    EXPECT_NEAR(arm.drive(10.0), trajectory.duration(), 0.03 * trajectory.duration());
    EXPECT_LT(arm.worst(), 2e-3);
    EXPECT_FALSE(arm.time_falls());
    EXPECT_NEAR((arm.measured().q - trajectory.end()).norm(), 0.0, 2e-3);
  }
}

TEST(TrajectoryTracking, FollowsPointsWithoutVelocities) {
  TrackingArm arm;
  const TimedTrajectory trajectory = trapezoid(false, false, 0.05);
  arm.start(trajectory);
  EXPECT_NEAR(arm.drive(10.0), trajectory.duration(), 0.05 * trajectory.duration());
  EXPECT_LT(arm.worst(), 7e-3);
}

/// Six prismatic joints in one line: only their limits count.
Arm six_joints() {
  auto model = std::make_shared<RobotModel>();
  model->name = "six_joints";
  model->links.resize(7);
  model->links[0].name = "ground";
  for (int j = 0; j < 6; ++j) {
    const std::string name(1, static_cast<char>('a' + j));
    model->links[static_cast<std::size_t>(j) + 1] = {
        name, j, JointType::kPrismatic, name, Pose::Identity(), Eigen::Vector3d::UnitX(), j};
    model->joint_names.push_back(name);
  }
  LinkGeometry& ball = model->geometry.emplace_back();
  ball.link = 6;
  ball.shape = world::Sphere{0.05};
  const auto all = [](double value) { return JointVector(JointVector::Constant(6, value)); };
  model->limits = {all(-6.0), all(6.0), all(1.5), all(6.0)};
  model->tool_link = 6;
  Arm arm;
  arm.name = "six";
  arm.model = model;
  arm.limits = model->limits;
  arm.named["home"] = all(0.0);
  return arm;
}

/// Through four random points with a share of the limits, sampled each 0.1 s with velocities.
TimedTrajectory random_time_optimal(const JointLimits& limits, double share, std::uint64_t seed, Trajectory& exact) {
  Random random(seed);
  std::vector<Eigen::VectorXd> points;
  for (int i = 0; i < 4; ++i)
    points.emplace_back(Eigen::VectorXd::NullaryExpr(6, [&] { return random.uniform(-1.5, 1.5); }));
  exact = time_optimal(blended(points, [](const auto&, const auto&, const auto&) { return true; }, {0.1, 6}),
                       {share * limits.velocity, share * limits.acceleration});
  TimedTrajectory trajectory;
  const int count = static_cast<int>(std::ceil(exact.duration() / 0.1));
  for (int i = 0; i <= count; ++i) {
    const double time = i == count ? exact.duration() : 0.1 * i;
    const auto point = exact.at(time);
    trajectory.points.push_back({time, JointVector(point.q), JointVector(point.qd), {}});
  }
  trajectory.points.back().qd.setZero();
  return trajectory;
}

TEST(TrajectoryTracking, FollowsTimeOptimalTrajectoriesOfSixJoints) {
  const Arm arm = six_joints();
  for (const double share : {0.1, 0.3, 0.6, 1.0}) {
    double worst = 0.0;
    double longest = 0.0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      Trajectory exact;
      const TimedTrajectory trajectory = random_time_optimal(arm.limits, share, seed, exact);
      ArmController controller(CellGeometry({arm}, 0), LocalParameters{}, kPeriod, 3);
      controller.set_goal(trajectory.end(), std::make_shared<const TimedTrajectory>(trajectory));
      MeasuredState measured{trajectory.points[0].q, JointVector(JointVector::Zero(6))};
      const std::vector<ArmObservation> arms(1);
      double time = 0.0;
      for (bool reached = false; !reached && time < 2.0 * exact.duration();) {
        const TickResult result = controller.step(measured, arms, {}, false);
        measured = {result.q, result.qd};
        time += kPeriod;
        reached = result.status == TickStatus::kReached;
        worst = std::max(worst, (exact.at(time).q - result.q).cwiseAbs().maxCoeff());
      }
      longest = std::max(longest, time / exact.duration());
    }
    std::cout << "share " << share << ": error " << 1e3 * worst << " mrad, duration x" << longest << "\n";
    if (share < 1.0) {
      EXPECT_LT(worst, 2e-3);
    }
    EXPECT_LT(longest, share < 1.0 ? 1.01 : 1.1);
  }
}

TEST(TrajectoryTracking, KeepsItsTimeWithSmallPathTolerances) {
  for (const double tolerance : {0.003, 0.01, 0.1}) {
    TrackingArm arm;
    TimedTrajectory trajectory = trapezoid(true, false, 0.05);
    trajectory.path_tolerance = joints({tolerance, tolerance});
    arm.start(trajectory);
    EXPECT_NEAR(arm.drive(10.0), trajectory.duration(), 0.03 * trajectory.duration()) << tolerance;
    EXPECT_LT(arm.worst(), std::min(2e-3, tolerance));
  }
}

// Two points demand a jump of the velocity, which no arm can make.
TEST(TrajectoryTracking, BrakesBeforeTheEndOfPointsWithoutVelocities) {
  TrackingArm arm;
  TimedTrajectory trajectory;
  trajectory.points = {{0.0, joints({-1, 0}), {}, {}}, {4.0, joints({0.9, 0}), {}, {}}};
  arm.start(trajectory);
  double farthest = -1.0;
  double elapsed = 0.0;
  while (elapsed < 6.0 && arm.step().status != TickStatus::kReached) {
    elapsed += kPeriod;
    farthest = std::max(farthest, arm.measured().q[0]);
  }
  EXPECT_LT(elapsed, 4.5);
  EXPECT_LT(farthest, 0.9 + 2e-3);
}

TEST(TrajectoryTracking, SlowsItsTimeWithTheSpeedOverride) {
  TrackingArm arm;
  arm.controller().order_speed(0.5);
  const TimedTrajectory trajectory = trapezoid(true);
  arm.start(trajectory);
  EXPECT_NEAR(arm.drive(20.0), 2.0 * trajectory.duration(), 0.1 * trajectory.duration());
  EXPECT_LT(arm.worst(), 2e-3);
}

TEST(TrajectoryTracking, WaitsAtAnObstacleAndGoesOnAfterwards) {
  TimedTrajectory trajectory = trapezoid(true);
  trajectory.path_tolerance = joints({0.1, 0.1});
  TrackingArm arm({test::box_obstacle("box", {0.3, 0, 0}, {0.1, 0.1, 0.2})});
  arm.start(trajectory);
  for (int i = 0; i < 1500; ++i) arm.step();
  const double waits = arm.tracking().time;
  EXPECT_LT(arm.measured().q[0], 0.15);
  EXPECT_NEAR(arm.tracking().rate, 0.0, 1e-6);
  EXPECT_EQ(outside_path_tolerance(test::planar_point().limits, arm.measured().q, arm.tracking()), -1);
  arm.set_obstacles({});
  double left = 0.0;
  while (left < 10.0 && arm.step().status != TickStatus::kReached) left += kPeriod;
  EXPECT_NEAR(left, trajectory.duration() - waits, 0.5);
  EXPECT_FALSE(arm.time_falls());
  EXPECT_LT(arm.worst(), 0.06);
}

/// The largest deviation from the trajectory at its own time, as a share of the path tolerance.
double deviation(const TrackingArm& arm, const JointVector& tolerance) {
  const JointVector off = arm.measured().q - arm.tracking().at(arm.tracking().time).q;
  return off.cwiseAbs().cwiseQuotient(tolerance).maxCoeff();
}

// The ball of radius 0.05 keeps 0.02 from the box, whose lower side is at y = −0.02: 0.09 aside suffices.
TEST(TrajectoryTracking, GoesAroundWithinThePathTolerance) {
  TimedTrajectory trajectory = trapezoid(true);
  trajectory.path_tolerance = joints({0.15, 0.15});
  TrackingArm arm({test::box_obstacle("box", {0.0, 0.08, 0}, {0.1, 0.1, 0.2})});
  arm.start(trajectory);
  double worst = 0.0;
  bool around = false;
  double elapsed = 0.0;
  while (elapsed < 60.0 && arm.step().status != TickStatus::kReached) {
    elapsed += kPeriod;
    worst = std::max(worst, deviation(arm, trajectory.path_tolerance));
    around = around || arm.tracking().phase == TrackingPhase::kAround;
  }
  EXPECT_TRUE(around);
  EXPECT_LT(elapsed, 60.0);
  EXPECT_LE(worst, 1.0);
  EXPECT_GT(worst, 0.5);
  EXPECT_FALSE(arm.time_falls());
  EXPECT_NEAR((arm.measured().q - trajectory.end()).norm(), 0.0, 2e-3);
}

/// Distance of the ball at q to a box or to a ball.
double distance_to(const world::Obstacle& obstacle, const JointVector& q) {
  const Eigen::Vector3d centre = Eigen::Vector3d(q[0], q[1], 0.0) - obstacle.X_WO.translation();
  const auto& shape = obstacle.shapes.front().shape;
  if (const auto* ball = std::get_if<world::Sphere>(&shape)) return centre.norm() - ball->radius - 0.05;
  const Eigen::Vector3d outside = centre.cwiseAbs() - std::get<world::Box>(shape).half_extents;
  return outside.cwiseMax(0.0).norm() - 0.05;
}

/// There is a way past the obstacles within `share` of the path tolerance, 5 mm beyond the security distance: the
/// points of a grid around the trajectory's position at one time are reached from those at the time before.
bool has_way(const TimedTrajectory& trajectory, const std::vector<world::Obstacle>& obstacles, double share) {
  constexpr double kGrid = 0.01;
  constexpr int kWidth = 300, kHeight = 200;
  const auto position = [&](int point) {
    return joints({kGrid * (point % kWidth - kWidth / 2), kGrid * (point / kWidth - kHeight / 2)});
  };
  std::vector<char> free(kWidth * kHeight, 1);
  for (int point = 0; point < kWidth * kHeight; ++point) {
    for (const auto& obstacle : obstacles)
      if (distance_to(obstacle, position(point)) < 0.025) free[static_cast<std::size_t>(point)] = 0;
  }
  const JointVector reach = share * trajectory.path_tolerance + JointVector::Constant(2, 0.5 * kGrid);
  const JointVector& start = trajectory.points.front().q;
  std::set<int> reached{static_cast<int>(std::lround(start[0] / kGrid)) + kWidth / 2 +
                        kWidth * (static_cast<int>(std::lround(start[1] / kGrid)) + kHeight / 2)};
  for (double time = 0.0; time <= trajectory.duration(); time += 0.02) {
    const JointVector centre = trajectory.at(time).q;
    const auto inside = [&](int point) {
      return free.at(static_cast<std::size_t>(point)) != 0 &&
             ((position(point) - centre).cwiseAbs().array() <= reach.array()).all();
    };
    std::erase_if(reached, [&](int point) { return !inside(point); });
    std::vector<int> open(reached.begin(), reached.end());
    while (!open.empty()) {
      const int from = open.back();
      open.pop_back();
      for (const int next : {from + 1, from - 1, from + kWidth, from - kWidth})
        if (inside(next) && reached.insert(next).second) open.push_back(next);
    }
  }
  return !reached.empty();
}

// Random obstacles on and beside the path, and random tolerances of each joint.
TEST(TrajectoryTracking, NeverLeavesThePathTolerance) {
  Random random(7);
  double worst = 0.0;
  double nearest = 1.0;
  int passed = 0, around = 0, possible = 0, missed = 0;
  constexpr int kCells = 100;
  for (int cell = 0; cell < kCells; ++cell) {
    TimedTrajectory trajectory = trapezoid(true, random.uniform() < 0.5, random.uniform(-0.3, 0.3));
    trajectory.path_tolerance = joints({random.uniform(0.02, 0.3), random.uniform(0.02, 0.3)});
    if (random.uniform() < 0.2) trajectory.path_tolerance[0] = std::numeric_limits<double>::infinity();
    std::vector<world::Obstacle> obstacles;
    const int count = 1 + static_cast<int>(random.uniform(0.0, 3.0));
    for (int i = 0; i < count; ++i) {
      const JointVector on_path = trajectory.at(random.uniform(1.5, 4.0)).q;
      const Eigen::Vector3d centre(on_path[0], on_path[1] + random.uniform(-0.25, 0.25), 0.0);
      world::Obstacle obstacle = test::box_obstacle("o" + std::to_string(i), centre,
                                                    {random.uniform(0.02, 0.15), random.uniform(0.02, 0.15), 0.2});
      if (random.uniform() < 0.5) obstacle.shapes.front().shape = world::Sphere{random.uniform(0.02, 0.15)};
      obstacles.push_back(obstacle);
    }
    TrackingArm arm(obstacles);
    arm.start(trajectory);
    bool goes_around = false;
    for (double elapsed = 0.0; elapsed < 60.0; elapsed += kPeriod) {
      const bool reached = arm.step().status == TickStatus::kReached;
      worst = std::max(worst, deviation(arm, trajectory.path_tolerance));
      for (const auto& obstacle : obstacles) nearest = std::min(nearest, distance_to(obstacle, arm.measured().q));
      goes_around = goes_around || arm.tracking().phase == TrackingPhase::kAround;
      if (!reached) continue;
      ++passed;
      around += goes_around ? 1 : 0;
      break;
    }
    EXPECT_FALSE(arm.time_falls());
    if (!trajectory.path_tolerance.allFinite() || !has_way(trajectory, obstacles, 0.75)) continue;
    ++possible;
    missed += arm.tracking().phase == TrackingPhase::kDone ? 0 : 1;
  }
  std::cout << "a way for " << possible << ", not found for " << missed << "; " << passed << " of " << kCells
            << " passed, " << around << " of them around something; deviation " << worst
            << " of the tolerance, distance " << 1e3 * nearest << " mm\n";
  EXPECT_LE(worst, 1.0);
  EXPECT_GT(nearest, 0.0);
  EXPECT_GT(around, 15);
  EXPECT_LT(missed, possible / 10);
}

/// A straight joint motion at constant speed between two ramps, with velocities.
TimedTrajectory straight(const JointVector& from, const JointVector& to, double duration) {
  constexpr double kRamp = 0.5;
  TimedTrajectory trajectory;
  const double speed = 1.0 / (duration - kRamp);
  for (double t = 0.0; t < duration + 0.05; t += 0.1) {
    double s = speed * (t - 0.5 * kRamp), v = speed;
    if (t < kRamp) s = 0.5 * speed / kRamp * t * t, v = speed / kRamp * t;
    if (const double left = std::max(0.0, duration - t); left < kRamp)
      s = 1.0 - 0.5 * speed / kRamp * left * left, v = speed / kRamp * left;
    trajectory.points.push_back({t, from + s * (to - from), v * (to - from), {}});
  }
  return trajectory;
}

// Each box is near the tool's place in the middle of the trajectory.
TEST(TrajectoryTracking, AnArmOfSixJointsNeverLeavesThePathTolerance) {
  Random random(11);
  const Arm puma = test::puma();
  const std::vector<ArmObservation> arms(1);
  double worst = 0.0, nearest = 1.0;
  int cells = 0, passed = 0, around = 0;
  while (cells < 40) {
    JointVector from(6), way(6), tolerance(6);
    for (int j = 0; j < 6; ++j) {
      from[j] = random.uniform(-1.5, 1.5);
      way[j] = random.uniform(-0.8, 0.8);
      tolerance[j] = random.uniform(0.05, 0.4);
    }
    TimedTrajectory trajectory = straight(from, from + way, 4.0);
    trajectory.path_tolerance = tolerance;
    Kinematics kinematics;
    forward_kinematics(*puma.model, puma.X_WB, JointVector(from + 0.5 * way), kinematics);
    Eigen::Vector3d centre = kinematics.X_WT.translation();
    for (auto& value : centre) value += random.uniform(-0.15, 0.15);
    const std::vector<world::Obstacle> boxes{test::box_obstacle("box", centre, {0.06, 0.06, 0.06})};
    const std::vector<world::ObstacleState> states{{boxes[0].X_WO, {}, 0.0}};
    const auto controller_of = [&] {
      ArmController controller(CellGeometry({puma}, 0), LocalParameters{}, kPeriod, 3);
      controller.set_obstacles(boxes);
      return controller;
    };
    const JointVector still = JointVector::Zero(6);
    const auto free = [&](const JointVector& q) {
      return controller_of().step(MeasuredState{q, still}, arms, states, false).clearance_margin > 0.05;
    };
    if (objection(trajectory, puma.limits, puma.model->joint_names) || !free(from) || !free(from + way)) continue;
    ++cells;
    ArmController controller = controller_of();
    controller.set_goal(trajectory.end(), std::make_shared<const TimedTrajectory>(trajectory));
    MeasuredState measured{from, still};
    bool goes_around = false;
    for (double elapsed = 0.0; elapsed < 40.0; elapsed += kPeriod) {
      const TickResult result = controller.step(measured, arms, states, false);
      measured = {result.q, result.qd};
      const TrajectoryTracking& tracking = controller.memory().tracking;
      worst =
          std::max(worst, (measured.q - tracking.at(tracking.time).q).cwiseAbs().cwiseQuotient(tolerance).maxCoeff());
      nearest = std::min(nearest, result.clearance_margin + LocalParameters{}.damper.security_distance);
      goes_around = goes_around || tracking.phase == TrackingPhase::kAround;
      if (result.status != TickStatus::kReached) continue;
      ++passed;
      around += goes_around ? 1 : 0;
      break;
    }
  }
  std::cout << passed << " of " << cells << " passed, " << around << " of them around the box; deviation " << worst
            << " of the tolerance, distance " << 1e3 * nearest << " mm\n";
  EXPECT_LE(worst, 1.0);
  EXPECT_GT(nearest, 0.0);
  EXPECT_GT(around, 0);
}

TEST(TrajectoryTracking, GoesAroundWithoutPathTolerance) {
  TrackingArm arm({test::box_obstacle("box", {0.0, 0.02, 0}, {0.1, 0.2, 0.2})});
  arm.start(trapezoid(true));
  EXPECT_LT(arm.drive(40.0), 40.0);
  EXPECT_FALSE(arm.time_falls());
}

TEST(TrajectoryTracking, ContinuesWhereAHeldArmStands) {
  TrackingArm arm;
  const TimedTrajectory trajectory = trapezoid(true);
  arm.start(trajectory);
  for (int i = 0; i < 200; ++i) arm.step();
  for (int i = 0; i < 100; ++i) arm.step(true);
  const double held = arm.measured().q[0];
  for (int i = 0; i < 300; ++i) {
    arm.step();
    EXPECT_GE(arm.measured().q[0], held - 0.02);
  }
  EXPECT_LT(arm.drive(10.0), trajectory.duration() + 1.5);
}

TEST(TrajectoryTracking, BeginsAtTheMotionOfTheArmThatItReplaces) {
  TrackingArm arm;
  arm.start(trapezoid(true));
  for (int i = 0; i < 200; ++i) arm.step();
  const double speed = arm.measured().qd[0];
  TimedTrajectory next;
  next.points = {{1.0, arm.measured().q + joints({0.4, 0.1}), joints({0.4, 0.1}), {}},
                 {2.0, arm.measured().q + joints({0.6, 0.15}), joints({0, 0}), {}}};
  arm.start(next);
  for (int i = 0; i < 90; ++i) {
    arm.step();
    EXPECT_GT(arm.measured().qd[0], 0.7 * speed);
  }
}

// A standby planner has followed the goal but has commanded nothing.
TEST(TrajectoryTracking, ContinuesAtTheArmsPlaceWhenAnotherPlannerHasBegunIt) {
  TrackingArm arm;
  const TimedTrajectory trajectory = trapezoid(true, false, 0.05);
  const JointState there = trajectory.at(2.6);
  arm.place(there.q, there.qd);
  arm.start(trajectory, 2.0);
  arm.step();
  EXPECT_NEAR(arm.tracking().time, 2.6, 0.05);
  EXPECT_GT(arm.tracking().rate, 0.9);
  EXPECT_LT(arm.drive(10.0), trajectory.duration() - 2.6 + 0.2);
  EXPECT_LT(arm.worst(), 0.02);
}

TEST(TrajectoryTracking, NamesTheJointOutsideThePathTolerance) {
  TrackingArm arm;
  TimedTrajectory trajectory = trapezoid(true);
  trajectory.path_tolerance = joints({0.05, std::numeric_limits<double>::infinity()});
  arm.start(trajectory);
  for (int i = 0; i < 200; ++i) arm.step();
  const JointLimits limits = test::planar_point().limits;
  const JointVector q = arm.measured().q;
  EXPECT_EQ(outside_path_tolerance(limits, q, arm.tracking()), -1);
  EXPECT_EQ(outside_path_tolerance(limits, q + joints({0.0, 1.0}), arm.tracking()), -1);
  EXPECT_EQ(outside_path_tolerance(limits, q + joints({0.5, 0.0}), arm.tracking()), 0);
}

TEST(TrajectoryTracking, LoadsTheMemoryThatItSaved) {
  TrackingArm arm;
  arm.start(trapezoid(true));
  for (int i = 0; i < 200; ++i) arm.step();
  MemoryArchive saved;
  arm.controller().describe(saved);
  const std::vector<std::uint32_t> words = saved.take_words();
  TrackingArm other;
  MemoryArchive loaded(words, 1, 2);
  other.controller().describe(loaded);
  ASSERT_TRUE(loaded.complete());
  other.place(arm.measured().q, arm.measured().qd);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(other.step().q, arm.step().q);
}

TEST(TimedTrajectory, NamesWhatNoArmCanFollow) {
  const JointLimits limits = test::planar_point().limits;
  const auto why = [&](auto change) {
    TimedTrajectory trajectory = trapezoid(true);
    change(trajectory);
    return objection(trajectory, limits, {"x", "y"}).value_or("");
  };
  EXPECT_EQ(why([](auto&) {}), "");
  EXPECT_NE(why([](auto& t) { t.points.clear(); }).find("0 points"), std::string::npos);
  EXPECT_NE(why([](auto& t) { t.points[3].time = t.points[2].time; }).find("the time of point 3"), std::string::npos);
  EXPECT_NE(why([](auto& t) { t.points[3].q = joints({1}); }).find("point 3"), std::string::npos);
  EXPECT_NE(why([](auto& t) { t.points[3].qd[0] = NAN; }).find("finite"), std::string::npos);
  EXPECT_NE(why([](auto& t) { t.points[3].q[1] = 4.0; }).find("joint y = 4 of point 3"), std::string::npos);
  EXPECT_NE(why([](auto& t) { t.points.back().qd[0] = 0.1; }).find("velocity 0, not 0.1"), std::string::npos);
  EXPECT_NE(why([](auto& t) { t.path_tolerance = joints({0.1, 0.0}); }).find("path_tolerance"), std::string::npos);
}

}  // namespace
}  // namespace hecaton::planner
