#include "planner/tick.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/old_news.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/model/link_poses.hpp"
#include "planner/model/speed_kernel.hpp"
#include "planner/simd/instruction_set.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// The bounding balls of an arm's bodies, placed anew in every tick.
std::vector<CarriedBall> carried_balls(const RobotModel& model, const Kinematics& kinematics,
                                       const std::vector<Body>& bodies) {
  std::vector<CarriedBall> balls;
  for (const Body& body : bodies) {
    CarriedBall& ball = balls.emplace_back();
    ball.X_WL = kinematics.X_WL[body.link].data();
    for (int i = 0; i < 3; ++i) ball.centre_L[i] = body.bound.centre[i];
    ball.radius = body.bound.radius;
    ball.joints = joints_before(model, body.link);
  }
  return balls;
}

/// No point of an obstacle is farther from its origin than this [m].
double radius_of(const std::vector<Body>& bodies) {
  double reach = 0.0;
  for (const Body& body : bodies) reach = std::max(reach, body.bound.centre.norm() + body.bound.radius);
  return reach;
}

}  // namespace

struct TickScratch::Storage {
  explicit Storage(const CellGeometry& geometry) : distance(geometry), arms(geometry.arms().size()) {
    rebuild(geometry);
  }

  void rebuild(const CellGeometry& geometry) {
    distance.rebuild(geometry);
    own_speed.assign(geometry.own_bodies().size(), 0.0);
    gap_to_arm.clear();
    fastest_other = 0.0;
    strongest_other = 0.0;
    longest_stop = 0.0;
    stop_times.clear();
    for (int i = 0; i < static_cast<int>(geometry.arms().size()); ++i) {
      gap_to_arm.push_back(geometry.gap_to_arm(i));
      const double lever = std::max(1.0, 2.0 * geometry.arm_reach(i).radius);
      const JointLimits& limits = geometry.arms()[i].limits;
      fastest_other = std::max(fastest_other, limits.velocity.sum() * lever);
      strongest_other = std::max(strongest_other, limits.acceleration.sum() * lever);
      stop_times.push_back(std::max(longest_stop_time(geometry.own_arm().limits), longest_stop_time(limits)));
      longest_stop = std::max(longest_stop, stop_times.back());
    }
    balls_of_arm.clear();
    for (int i = 0; i < static_cast<int>(geometry.arms().size()); ++i) {
      const Kinematics& kinematics = i == geometry.self() ? own : arms[i];
      balls_of_arm.push_back(carried_balls(*geometry.arms()[i].model, kinematics, geometry.arm_bodies(i)));
    }
    radius_of_obstacle.clear();
    for (int i = 0; i < geometry.obstacle_count(); ++i) {
      radius_of_obstacle.push_back(radius_of(geometry.obstacle_bodies(i)));
    }
    near_arms.reserve(geometry.arms().size());
    observations.resize(geometry.arms().size());
    obstacles.resize(geometry.obstacle_count());
    reach_of_arm.assign(geometry.arms().size(), {});
    reach_of_obstacle.assign(geometry.obstacle_count(), {});
    clearances.resize(kMaxRows);
  }

  ExactDistance distance;
  Kinematics own;
  std::vector<Kinematics> arms;
  std::vector<double> own_speed;   ///< of each own body's fastest point in the next period, at most [m/s]
  std::vector<double> gap_to_arm;  ///< the least distance to each arm, whatever both do [m]
  double fastest_other = 0.0;      ///< no point of any arm moves faster [m/s]
  double strongest_other = 0.0;    ///< nor gets faster in a second [m/s²]
  double longest_stop = 0.0;       ///< of any arm [s]
  double out_of_sight = 0.0;       ///< arms whose gap is larger cannot matter now [m]
  std::vector<std::vector<CarriedBall>> balls_of_arm;  ///< around each body of each arm, the own one included
  std::vector<double> radius_of_obstacle;              ///< no point is farther from its origin [m]
  std::vector<int> near_arms;                          ///< those that can matter now
  std::vector<ArmObservation> observations;            ///< extrapolated to now
  std::vector<world::ObstacleState> obstacles;         ///< extrapolated to now, if any is old
  std::vector<double> stop_times;                      ///< against each arm: the longer of both arms' longest stop [s]
  std::vector<Reach> reach_of_arm;                     ///< how near each arm must be to matter
  std::vector<Reach> reach_of_obstacle;                ///< and each obstacle
  std::vector<Clearance> clearances;
  std::array<Row, kMaxRows> rows;
};

TickScratch::TickScratch(const CellGeometry& geometry) : storage_(std::make_unique<Storage>(geometry)) {}
TickScratch::~TickScratch() = default;
TickScratch::TickScratch(TickScratch&&) noexcept = default;
TickScratch& TickScratch::operator=(TickScratch&&) noexcept = default;
void TickScratch::rebuild(const CellGeometry& geometry) {
  storage_->rebuild(geometry);
}

namespace {

/// Who is too old or unknown: the arm's index, `kObstacles`, or −1.
constexpr int kNobody = -1;
constexpr int kObstacles = -2;

int find_stale(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input) {
  for (int i = 0; i < static_cast<int>(input.arms.size()); ++i) {
    if (i == geometry.self()) continue;
    if (!input.arms[i].known || input.arms[i].age > parameters.state_age_limit) return i;
  }
  for (const auto& obstacle : input.obstacles) {
    if (obstacle.age > parameters.state_age_limit) return kObstacles;
  }
  return kNobody;
}

/// Places an arm's balls and bounds how fast any point of each moves, and so how fast any row of it can make it
/// approach, for joints no faster than `speed`.
void bound_speeds(const Kinematics& kinematics, const JointVector& speed, std::vector<CarriedBall>& balls) {
  static const SpeedKernel kernel = fastest(baseline::bound_speeds, avx2::bound_speeds);
  const auto& w = kinematics.angular_W;
  const auto& v = kinematics.linear_W;
  std::array<double, kMaxJoints> padded;
  for (Eigen::Index j = 0; j < speed.size(); ++j) padded[j] = speed[j];
  std::fill(padded.begin() + speed.size(), padded.end(), 0.0);
  kernel({{w[0].data(), w[1].data(), w[2].data()}, {v[0].data(), v[1].data(), v[2].data()}}, padded.data(),
         balls.data(), static_cast<int>(balls.size()));
}

double fastest_point(const Kinematics& kinematics, const JointVector& speed, std::vector<CarriedBall>& balls) {
  bound_speeds(kinematics, speed, balls);
  double fastest = 0.0;
  for (const CarriedBall& ball : balls) fastest = std::max(fastest, ball.fastest);
  return fastest;
}

/// The same for an obstacle that reaches `radius` [m] from its origin.
double fastest_point(double radius, const world::Twist& velocity) {
  return velocity.linear.norm() + velocity.angular.norm() * radius;
}

/// A row matters while its bound can be reached: from where the damper allows just the speed at which the own body and
/// the counterpart approach each other at most; and while it limits how long a stop may take. `shares`: 2 when both
/// give way, each with half of the damper, else 1. `margin`: how much nearer than expected the counterpart may be.
Reach reach_of(const Damper& damper, double margin, double speed_of_other, double shares) {
  const double nearest = margin + damper.security_distance;
  const double seconds = damper.longest();
  return {nearest + damper.convergence_speed * seconds, nearest + speed_of_other * seconds, shares * seconds};
}

/// How far a point strays within `age` [s] from where it would be at constant velocity [m].
double stray(double acceleration, double age) {
  return 0.5 * acceleration * age * age;
}

/// Whether an arm may be near enough to matter, wherever its joints are: without its kinematics, so that a tick's cost
/// depends on an arm's neighbours and not on the cell.
bool may_matter(const CellGeometry& geometry, const LocalParameters& parameters, int arm, const ArmObservation& other,
                double dt, double own_speed, const TickScratch::Storage& s) {
  if (s.gap_to_arm[arm] > s.out_of_sight) return false;
  const world::BoundingSphere& reach = geometry.arm_reach(arm);
  const double lever = std::max(1.0, 2.0 * reach.radius);
  const Damper damper = parameters.damper.against_others(s.stop_times[arm] + dt);
  const double margin = stray(geometry.arms()[arm].limits.acceleration.sum() * lever, other.age);
  const Reach farthest =
      other.plans ? reach_of(damper, margin, 0.0, 2.0) : reach_of(damper, margin, other.qd.lpNorm<1>() * lever, 1.0);
  const double distance = InfluenceDistances::distance(farthest, own_speed) + reach.radius;
  const std::vector<CarriedBall>& own = s.balls_of_arm[geometry.self()];
  return std::any_of(own.begin(), own.end(), [&](const CarriedBall& ball) {
    const double sum = distance + ball.radius;
    return !((Eigen::Map<const Eigen::Vector3d>(ball.centre_W) - reach.centre).squaredNorm() > sum * sum);
  });
}

/// The same for all arms at once, whatever their states, as long as those are not too old to move at all.
double out_of_sight(const LocalParameters& parameters, double dt, double own_speed, const TickScratch::Storage& s) {
  const Damper damper = parameters.damper.against_others(s.longest_stop + dt);
  const double margin = stray(s.strongest_other, parameters.state_age_limit);
  return InfluenceDistances::distance(reach_of(damper, margin, s.fastest_other, 2.0), own_speed);
}

/// Brings every other arm in reach forward to now and finds how near each must be to matter.
void look_at_arms(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                  TickScratch::Storage& s) {
  const double own_speed = s.own_speed.empty() ? 0.0 : *std::max_element(s.own_speed.begin(), s.own_speed.end());
  s.out_of_sight = out_of_sight(parameters, input.dt, own_speed, s);
  s.near_arms.clear();
  for (int i = 0; i < static_cast<int>(geometry.arms().size()); ++i) {
    if (i == geometry.self()) continue;
    if (!may_matter(geometry, parameters, i, input.arms[i], input.dt, own_speed, s)) continue;
    s.near_arms.push_back(i);
    const Arm& arm = geometry.arms()[i];
    const ArmObservation& other = s.observations[i] = extrapolated(arm.limits, input.arms[i]);
    const bool counts_on_its_part = other.plans && other.age <= 0.0;  // then nobody asks how it moves
    (counts_on_its_part ? place_links : forward_kinematics)(*arm.model, arm.X_WB, other.q, s.arms[i]);
    const auto fastest = [&](const JointVector& speed) { return fastest_point(s.arms[i], speed, s.balls_of_arm[i]); };
    const Damper damper = parameters.damper.against_others(s.stop_times[i] + input.dt);
    const double margin = other.age > 0.0 ? stray(fastest(arm.limits.acceleration), other.age) : 0.0;
    s.reach_of_arm[i] =
        other.plans ? reach_of(damper, margin, 0.0, 2.0) : reach_of(damper, margin, fastest(other.qd.cwiseAbs()), 1.0);
  }
}

/// The obstacles as they should be now, and how near each must be to matter, or once for all that are equal.
struct Obstacles {
  std::span<const world::ObstacleState> now;
  std::span<const Reach> reach;
};

bool alike(const world::ObstacleState& a, const world::ObstacleState& b) {
  return a.age == b.age && a.velocity.linear == b.velocity.linear && a.velocity.angular.isZero(0.0) &&
         b.velocity.angular.isZero(0.0);
}

Obstacles look_at_obstacles(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                            TickScratch::Storage& s) {
  const auto count = static_cast<std::size_t>(geometry.obstacle_count());
  Obstacles obstacles{input.obstacles.first(count), s.reach_of_obstacle};
  if (std::any_of(obstacles.now.begin(), obstacles.now.end(), [](const auto& state) { return state.age > 0.0; })) {
    std::transform(obstacles.now.begin(), obstacles.now.end(), s.obstacles.begin(),
                   [](const world::ObstacleState& then) { return extrapolated(then); });
    obstacles.now = s.obstacles;
  }
  const bool all_alike = std::all_of(obstacles.now.begin(), obstacles.now.end(),
                                     [&](const auto& state) { return alike(state, obstacles.now.front()); });
  if (all_alike) obstacles.reach = obstacles.reach.first(std::min<std::size_t>(count, 1));
  const Damper damper = parameters.damper.against_others(s.stop_times[geometry.self()] + input.dt);
  for (std::size_t i = 0; i < obstacles.reach.size(); ++i) {
    const world::ObstacleState& state = obstacles.now[i];
    s.reach_of_obstacle[i] = reach_of(damper, stray(parameters.acceleration_of_obstacles, state.age),
                                      fastest_point(s.radius_of_obstacle[i], state.velocity), 1.0);
  }
  return obstacles;
}

/// Near things an arm goes no faster than lets it stop within what the dampers count on. Fills `slower` only if needed.
const JointLimits& limits_near(const JointLimits& limits, double stop_time, JointLimits& slower) {
  if (longest_stop_time(limits) <= stop_time) return limits;
  slower = limits;
  slower.velocity = limits.velocity.cwiseMin(limits.acceleration * stop_time);
  return slower;
}

struct BuiltRows {
  int count = 0;
  double stop_time = std::numeric_limits<double>::infinity();  ///< no longer than this while these things are near [s]
};

BuiltRows build_rows(const DamperScene& scene, const JointVector& fastest, std::span<const Clearance> clearances,
                     std::span<Row> rows) {
  BuiltRows built;
  bool flees = false;
  for (int i = 0; i < static_cast<int>(clearances.size()) && built.count < static_cast<int>(rows.size()); ++i) {
    Row& row = rows[built.count];
    row = velocity_damper(scene, clearances[i]);
    row.clearance = i;
    // What no joint moves cannot be helped by moving: such a row would only make the others infeasible.
    const double reach = row.g.cwiseAbs().dot(fastest);
    if (reach > 0.0) built.stop_time = std::min(built.stop_time, row.stop_time);
    flees = flees || (reach > 0.0 && row.h < 0.0);
    const bool can_bind = reach > row.h;
    if (reach > 0.0 && (row.influences || can_bind)) ++built.count;
  }
  // What must be fled is fled as fast as the arm can.
  if (flees) built.stop_time = std::numeric_limits<double>::infinity();
  return built;
}

TickResult brake(const CellGeometry& geometry, const TickInput& input, TickStatus status) {
  TickResult result;
  result.status = status;
  result.qd = braking_velocity(geometry.own_arm().limits, input.qd, input.dt);
  result.q = input.q + 0.5 * (input.qd + result.qd) * input.dt;
  return result;
}

}  // namespace

TickResult tick(const CellGeometry& geometry, const LocalParameters& parameters, const TickInput& input,
                TickMemory& memory, TickScratch& scratch) {
  TickScratch::Storage& s = scratch.storage();
  const Arm& arm = geometry.own_arm();
  if (input.hold) return brake(geometry, input, TickStatus::kHolding);
  if (const int stale = find_stale(geometry, parameters, input); stale != kNobody) {
    TickResult result = brake(geometry, input, TickStatus::kStaleInput);
    result.stale_arm = stale;
    return result;
  }

  forward_kinematics(*arm.model, arm.X_WB, input.q, s.own);
  const JointVector fastest = (input.qd.cwiseAbs() + arm.limits.acceleration * input.dt).cwiseMin(arm.limits.velocity);
  std::vector<CarriedBall>& own_balls = s.balls_of_arm[geometry.self()];
  bound_speeds(s.own, fastest, own_balls);
  for (std::size_t i = 0; i < s.own_speed.size(); ++i) s.own_speed[i] = own_balls[i].fastest;
  look_at_arms(geometry, parameters, input, s);
  const Obstacles obstacles = look_at_obstacles(geometry, parameters, input, s);
  const int near = s.distance.clearances(
      {&s.own, s.arms, obstacles.now},
      {.own_speed = s.own_speed,
       .of_arm = s.reach_of_arm,
       .of_obstacle = obstacles.reach,
       .of_self = reach_of(parameters.damper.against_self(s.stop_times[geometry.self()] + input.dt), 0.0, 0.0, 1.0),
       .near_arms = std::span<const int>(s.near_arms)},
      s.clearances);
  const DamperScene scene{geometry, s.own,          input.qd,     input.tracking_error,
                          s.arms,   s.observations, s.stop_times, obstacles.now,
                          input.dt, parameters};
  const BuiltRows rows = build_rows(scene, fastest, std::span(s.clearances).first(near), s.rows);
  JointLimits slower;
  const JointLimits& limits = limits_near(arm.limits, rows.stop_time, slower);

  const JointVector& q_goal = input.has_goal ? input.q_goal : input.q;
  const LocalResult local =
      plan_locally({limits, parameters, input.q, input.qd, q_goal, input.dt, std::span(s.rows).first(rows.count),
                    input.arms, geometry.self(), input.has_goal},
                   memory.local);

  TickResult result;
  result.qd = local.qd;
  result.q = input.q + 0.5 * (input.qd + local.qd) * input.dt;
  result.rows = rows.count;
  result.relaxed = local.relaxed;
  result.near = std::any_of(s.rows.begin(), s.rows.begin() + rows.count, [](const Row& row) { return row.influences; });
  result.yields_to = local.yields_to;
  result.redraws = memory.local.follower.redraws;
  if (local.binding_row >= 0) {
    result.has_binding = true;
    result.binding = s.clearances[s.rows[local.binding_row].clearance];
  }
  const bool at_goal = input.has_goal && (input.q_goal - input.q).cwiseAbs().maxCoeff() < parameters.goal_tolerance &&
                       input.qd.cwiseAbs().maxCoeff() < 10.0 * parameters.goal_tolerance;
  result.status = !input.has_goal        ? TickStatus::kIdle
                  : at_goal              ? TickStatus::kReached
                  : local.yields_to >= 0 ? TickStatus::kYielding
                  : local.blocked        ? TickStatus::kBlocked
                  : local.following      ? TickStatus::kFollowing
                  : local.detouring      ? TickStatus::kDetouring
                                         : TickStatus::kMoving;
  return result;
}

}  // namespace hecaton::planner
