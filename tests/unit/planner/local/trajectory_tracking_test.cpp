#include "planner/local/trajectory_tracking.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/local/random.hpp"
#include "planner/trajectory/time_optimal.hpp"
#include "tests/support/planar_point.hpp"

namespace hecaton::planner {
namespace {

using test::joints;

constexpr double kPeriod = 0.01;

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
  trajectory.path_tolerance = joints({0.2, 0.2});
  TrackingArm arm({test::box_obstacle("box", {0.3, 0, 0}, {0.1, 0.1, 0.2})});
  arm.start(trajectory);
  for (int i = 0; i < 1500; ++i) arm.step();
  const double waits = arm.tracking().time;
  EXPECT_TRUE(arm.tracking().follows());
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
