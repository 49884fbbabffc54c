// An arm never touches itself (docs/explanation/0020-stop-paths.md): arms under the real tick and a simulated drive get
// random goals, stop at random and miss set-points. Distances are measured at every step of the drive.
#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "planner/arm_controller.hpp"
#include "planner/collision/exact_distance.hpp"
#include "planner/local/default_damper.hpp"
#include "planner/local/stop_path_check.hpp"
#include "planner/model/collision_filter.hpp"
#include "planner/simulation/arm_model.hpp"
#include "planner/trajectory/stop_profile.hpp"
#include "services/config/cell_file.hpp"
#include "tests/unit/planner/collision/random_shapes.hpp"

namespace hecaton::planner {
namespace {

using test::uniform;

constexpr double kPeriod = 0.01;   // [s]
constexpr int kDriverSteps = 5;    // in a period
constexpr double kTimeout = 0.05;  // of the drive [s]

struct Tally {
  long periods = 0;
  long fast = 0;          ///< periods in which some joint moves at half of its limit at least
  long reached = 0;       ///< goals
  long near = 0;          ///< steps with a pair nearer than its security distance
  long touched = 0;       ///< steps with contact
  double nearest = 10.0;  ///< [m]
};

class Drive {
 public:
  Drive(Arm arm, const LocalParameters& parameters, std::uint64_t seed)
      : arm_(std::move(arm)),
        parameters_(parameters),
        random_(seed),
        geometry_({arm_}, 0),
        distances_(geometry_),
        kinematics_(1),
        controller_(geometry_, parameters_, kPeriod, random_()) {}

  /// False if no start was found in which the arm is as far from itself as starts must be.
  bool begin() {
    const std::optional<JointVector> start = clear_posture();
    if (start) drive_.emplace(arm_.limits, *start, kTimeout);
    return start.has_value();
  }

  void run(double seconds, Tally& tally) {
    double next_goal = 0.0;
    int held = 0;
    int lost = 0;
    for (double now = 0.0; now < seconds; now += kPeriod) {
      if (now >= next_goal) {
        // Goals may be in contact: the arm goes as near to them as it can.
        if (uniform(random_, 0.0, 1.0) < 0.5) {
          controller_.set_goal(anywhere());
        } else if (const auto goal = clear_posture()) {
          controller_.set_goal(*goal);
        }
        next_goal = now + uniform(random_, 0.05, 1.5);
      }
      if (held == 0 && uniform(random_, 0.0, 1.0) < 0.005) held = 10;
      if (lost == 0 && uniform(random_, 0.0, 1.0) < 0.005) lost = std::uniform_int_distribution<int>(1, 12)(random_);
      if (lost > 0) {
        if (--lost == 0) controller_.forget_setpoint();
      } else {
        plan(held > 0, tally);
      }
      held = std::max(0, held - 1);
      for (int step = 0; step < kDriverSteps; ++step) {
        drive_->step(kPeriod / kDriverSteps);
        measure(tally);
      }
    }
  }

 private:
  void plan(bool hold, Tally& tally) {
    const MeasuredState at{drive_->q(), drive_->qd()};
    const std::array<ArmObservation, 1> seen{{{at.q, at.qd, 0.0, true, true}}};
    const TickResult result = controller_.step(at, seen, {}, hold);
    drive_->command(result.q, result.qd, kPeriod);
    ++tally.periods;
    tally.reached += result.status == TickStatus::kReached ? 1 : 0;
    tally.fast += (result.qd.cwiseAbs().array() > 0.5 * arm_.limits.velocity.array()).any() ? 1 : 0;
  }

  JointVector anywhere() {
    JointVector q = arm_.limits.lower;
    for (int j = 0; j < q.size(); ++j) q[j] = uniform(random_, arm_.limits.lower[j], arm_.limits.upper[j]);
    return q;
  }

  std::span<const Clearance> nearer(const JointVector& q, const InfluenceDistances& influence) {
    forward_kinematics(*arm_.model, arm_.X_WB, q, kinematics_[0]);
    const int count = distances_.clearances({kinematics_.data(), kinematics_, {}}, influence, near_);
    return std::span(near_).first(count);
  }

  std::optional<JointVector> clear_posture() {
    const InfluenceDistances needed{.self = parameters_.damper.self_security_distance, .self_share = kRestShare};
    for (int attempt = 0; attempt < 300; ++attempt) {
      const JointVector q = anywhere();
      if (nearer(q, needed).empty()) return q;
    }
    return std::nullopt;
  }

  void measure(Tally& tally) {
    double nearest = parameters_.damper.self_security_distance;
    for (const Clearance& c : nearer(drive_->q(), {.self = nearest})) nearest = std::min(nearest, c.distance);
    tally.near += nearest < parameters_.damper.self_security_distance ? 1 : 0;
    tally.touched += nearest <= 0.0 ? 1 : 0;
    tally.nearest = std::min(tally.nearest, nearest);
  }

  Arm arm_;
  LocalParameters parameters_;
  test::Random random_;
  CellGeometry geometry_;
  ExactDistance distances_;
  std::vector<Kinematics> kinematics_;
  ArmController controller_;
  std::optional<ArmModel> drive_;
  std::array<Clearance, 64> near_;
};

LocalParameters with_default_damper(const Arm& arm) {
  LocalParameters parameters;
  parameters.damper = default_damper(
      {.reach = arm_reach(arm).tool, .stop_time = longest_stop_time(arm.limits), .control_period = kPeriod});
  return parameters;
}

/// Short and long links of every shape, joints of every speed, and stops of 0.05 to 0.6 s. Links are so thick that
/// neighbours of neighbours pass close to each other. Some joints slide, and in some arms the third link follows the
/// first joint.
Arm stout_arm(test::Random& random) {
  const int moving = std::uniform_int_distribution<int>(3, 6)(random);
  const bool follows = moving > 3 && uniform(random, 0.0, 1.0) < 0.4;
  const int joints = follows ? moving - 1 : moving;
  auto model = std::make_shared<RobotModel>();
  model->name = "stout";
  model->links.emplace_back().name = "root";
  model->limits.lower.resize(joints);
  model->limits.upper.resize(joints);
  model->limits.velocity.resize(joints);
  model->limits.acceleration.resize(joints);
  const auto add_shape = [&](int link, double length) {
    const double radius = uniform(random, 0.15, 0.5) * std::min(length, 0.15);
    const double half = std::max(0.3 * length, 0.5 * length - uniform(random, 0.0, 1.2) * radius);
    world::Shape shape = world::Capsule{radius, half};
    const int kind = std::uniform_int_distribution<int>(0, 3)(random);
    if (kind == 1) shape = world::Cylinder{radius, half};
    if (kind == 2) shape = world::Box{{radius, 0.7 * radius, half}};
    if (kind == 3) shape = test::prism(7, radius, half, Eigen::Vector3d::Zero());
    Pose X_LS = Pose::Identity();
    X_LS.translation() = Eigen::Vector3d(uniform(random, -0.3, 0.3) * radius, 0.0, 0.5 * length);
    model->geometry.push_back({link, std::move(shape), X_LS, 0.0, {}});
  };
  double length = uniform(random, 0.1, 0.3);
  add_shape(0, length);
  int joint = 0;
  for (int i = 0; i < moving; ++i) {
    Link link;
    link.name = "link" + std::to_string(i + 1);
    link.joint_name = "joint" + std::to_string(i + 1);
    link.parent = i;
    link.joint_type = uniform(random, 0.0, 1.0) < 0.15 ? JointType::kPrismatic : JointType::kRevolute;
    link.X_PJ.translation().z() = length;
    const Eigen::Vector3d axes[] = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ(),
                                    test::random_direction(random)};
    link.axis = axes[std::uniform_int_distribution<int>(0, 3)(random)];
    length = uniform(random, 0.04, 0.4);
    add_shape(i + 1, length);
    if (follows && i == 2) {
      link.joint_type = model->links[1].joint_type;
      link.joint = 0;
      link.follows = model->has_followers = true;
      link.multiplier = uniform(random, -1.5, 1.5);
      link.offset = uniform(random, -0.2, 0.2);
    } else {
      link.joint = joint++;
      const double size = link.joint_type == JointType::kPrismatic ? 0.1 : 1.0;
      model->joint_names.push_back(link.joint_name);
      model->limits.lower[link.joint] = -size * uniform(random, 0.8, 3.1);
      model->limits.upper[link.joint] = size * uniform(random, 0.8, 3.1);
      model->limits.velocity[link.joint] = size * uniform(random, 0.5, 10.0);
      model->limits.acceleration[link.joint] = model->limits.velocity[link.joint] / uniform(random, 0.05, 0.6);
    }
    link.motion = joint_motion(link);
    model->links.push_back(link);
  }
  model->tool_link = moving;
  model->X_LT.translation().z() = length;
  model->self_pairs = pairs_of_separate_bodies(*model);
  automatic_filter(*model,
                   [](const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
                     return shape_distance(a, X_WA, b, X_WB).distance;
                   },
                   {.samples = 60, .proof_budget = 200, .close_budget = 500});
  Arm arm;
  arm.name = "stout";
  arm.model = model;
  arm.limits = model->limits;
  arm.named["home"] = JointVector::Zero(joints);
  return arm;
}

void print(const Tally& tally) {
  std::printf("%ld periods, %ld fast, %ld at a goal, %ld steps within dₛ, %ld in contact, nearest %.2f mm\n",
              tally.periods, tally.fast, tally.reached, tally.near, tally.touched, 1e3 * tally.nearest);
}

TEST(SelfContactProperty, HandThatPassesCloseToItsForearmNeverTouchesIt) {
  const Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/tests/data/cells/tight_wrist.yaml").cell;
  Tally tally;
  for (int trial = 0; trial < 6; ++trial) {
    Drive drive(cell.arms[0].arm, cell.arms[0].parameters, 10 + trial);
    ASSERT_TRUE(drive.begin());
    drive.run(15.0, tally);
  }
  print(tally);
  EXPECT_GT(tally.near, 0) << "or the pair was never close";
  EXPECT_GT(tally.fast, tally.periods / 10);
  EXPECT_GT(tally.reached, 0);
  EXPECT_EQ(tally.touched, 0);
}

TEST(SelfContactProperty, RandomArmsNeverTouchThemselves) {
  test::Random random(7);
  Tally tally;
  int arms = 0;
  for (int trial = 0; trial < 80; ++trial) {
    const Arm arm = stout_arm(random);
    if (arm.model->self_pairs.empty()) continue;
    Drive drive(arm, with_default_damper(arm), random());
    if (!drive.begin()) continue;
    ++arms;
    drive.run(4.0, tally);
  }
  std::printf("%d arms: ", arms);
  print(tally);
  EXPECT_GT(arms, 30);
  EXPECT_GT(tally.near, 0);
  EXPECT_GT(tally.fast, tally.periods / 20);
  EXPECT_EQ(tally.touched, 0);
}

/// A state of an arm, and a velocity that it can have one period later.
struct Motion {
  JointVector q;
  JointVector qd;
  JointVector qd_next;
  JointVector error;  ///< empty: none

  Motion(const JointLimits& limits, test::Random& random) : q(limits.lower), qd(q), qd_next(q) {
    const bool off_track = uniform(random, 0.0, 1.0) < 0.5;
    error.resize(off_track ? q.size() : 0);
    for (int j = 0; j < q.size(); ++j) {
      q[j] = uniform(random, limits.lower[j], limits.upper[j]);
      qd[j] = limits.velocity[j] * uniform(random, -1.0, 1.0);
      qd_next[j] = qd[j] + limits.acceleration[j] * kPeriod * uniform(random, -1.0, 1.0);
      if (off_track) error[j] = uniform(random, -0.01, 0.01);
    }
  }
  /// A period further, so that memory of the last period helps.
  void go_on() {
    q += 0.5 * kPeriod * (qd + qd_next);
    qd = qd_next;
  }
  [[nodiscard]] JointVector start() const { return error.size() > 0 ? JointVector(q + error) : q; }
  /// Evenly spaced places of the period and of the stop behind it.
  [[nodiscard]] std::vector<JointVector> path(const JointLimits& limits) const {
    constexpr int kPlaces = 60;
    std::vector<JointVector> places;
    for (int i = 0; i <= kPlaces; ++i) {
      const double t = kPeriod * i / kPlaces;
      places.push_back(start() + t * qd + 0.5 * t * t / kPeriod * (qd_next - qd));
    }
    const JointVector set_point = places.back();
    const double T = stop_time(limits, qd_next);
    const double way = T <= kPeriod ? 0.5 * kPeriod : 0.5 * T + kPeriod * kPeriod / (8.0 * T);
    for (int i = 1; i <= kPlaces; ++i) places.push_back(set_point + way * i / kPlaces * qd_next);
    return places;
  }
};

/// Lowest distance of two own bodies at places, and the largest difference of neighbours.
struct Lowest {
  double distance = 1e9;
  double step = 0.0;

  Lowest(const CellGeometry& geometry, const std::pair<int, int>& pair, const std::vector<JointVector>& places) {
    const Arm& arm = geometry.own_arm();
    const Body& a = geometry.own_bodies()[pair.first];
    const Body& b = geometry.own_bodies()[pair.second];
    const SweptCore core_a = make_swept_core(a.shape);
    const SweptCore core_b = make_swept_core(b.shape);
    Kinematics kinematics;
    double last = 0.0;
    for (const JointVector& q : places) {
      forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
      const double here =
          prepared_distance(core_a, kinematics.X_WL[a.link] * a.X_CS, core_b, kinematics.X_WL[b.link] * b.X_CS)
              .distance;
      if (distance < 1e9) step = std::max(step, std::abs(here - last));
      distance = std::min(distance, here);
      last = here;
    }
  }
};

TEST(StopPathCheck, ClearPathsKeepTheirDistancesAndMemoryDoesNotMatter) {
  constexpr double kAccuracy = 3e-6;  // of distances [m]
  test::Random random(5);
  long clear = 0;
  long refused = 0;
  long promised = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Arm arm = stout_arm(random);
    const DamperParameters damper = with_default_damper(arm).damper;
    const CellGeometry geometry({arm}, 0);
    ExactDistance distances(geometry);
    StopPathCheck kept(geometry);
    std::vector<Kinematics> kinematics(1);
    std::array<Clearance, 64> near;
    std::optional<Motion> motion;
    for (int state = 0; state < 60; ++state) {
      if (state % 3 == 0) {
        motion.emplace(arm.limits, random);
      } else {
        motion->go_on();
      }
      forward_kinematics(*arm.model, arm.X_WB, motion->q, kinematics[0]);
      const int count = distances.clearances({kinematics.data(), kinematics, {}}, {.self = 0.1}, near);
      const StopPathCheck::Start start{motion->q, motion->qd, motion->error, kPeriod, std::span(near).first(count)};
      StopPathCheck fresh(geometry);
      kept.begin(geometry, damper, start);
      fresh.begin(geometry, damper, start);
      const bool is_clear = kept.is_clear(motion->qd_next);
      ASSERT_EQ(fresh.is_clear(motion->qd_next), is_clear);
      ASSERT_EQ(fresh.refused(), kept.refused());
      const std::vector<JointVector> places = motion->path(arm.limits);
      const auto limit_of = [&](const std::pair<int, int>& pair) {
        return 0.5 * damper.against_self(0.0, geometry.widest(pair.first, pair.second)).security_distance;
      };
      if (is_clear) {
        ++clear;
        for (const auto& pair : geometry.self_pairs()) {
          const double limit = limit_of(pair);
          const double before = Lowest(geometry, pair, {motion->start()}).distance;
          const double loss = before >= 0.625 * limit ? 0.25 * limit : 0.0625 * limit;
          const double kept_distance = std::min(before, limit) - loss - kAccuracy;
          if (kept_distance <= 0.0) continue;  // no promise
          ++promised;
          ASSERT_GE(Lowest(geometry, pair, places).distance, kept_distance);
        }
      } else if (kept.refused()) {
        ++refused;
        const double before = Lowest(geometry, *kept.refused(), {motion->start()}).distance;
        const Lowest lowest(geometry, *kept.refused(), places);
        if (before > 0.0) {
          ASSERT_LE(lowest.distance, std::min(before, limit_of(*kept.refused())) + 2.0 * lowest.step + kAccuracy);
        }
        const Row row = kept.cut();
        ASSERT_EQ(fresh.cut().g, row.g);
        ASSERT_EQ(fresh.cut().h, row.h);
        EXPECT_GT(row.g.dot(motion->qd_next), row.h) << "or the row allows what was refused";
      }
    }
  }
  std::printf("%ld clear, %ld refused\n", clear, refused);
  EXPECT_GT(clear, 300);
  EXPECT_GT(promised, 1000);
  EXPECT_GT(refused, 200);
}

}  // namespace
}  // namespace hecaton::planner
