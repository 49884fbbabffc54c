#include "services/tick_log/tick_writer.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

using messages::to_message;

/// The columns of the rotation matrix, then the position. A quaternion would round.
void append_frame(const world::Pose& pose, std::vector<double>& to) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) to.push_back(pose.matrix()(row, column));
  }
}

bool same_bits(const world::ObstacleState& a, const world::ObstacleState& b) {
  const auto same = [](const auto& one, const auto& other) {
    return std::memcmp(one.data(), other.data(), sizeof(double) * static_cast<std::size_t>(one.size())) == 0;
  };
  return same(a.X_WO.matrix(), b.X_WO.matrix()) && same(a.velocity.linear, b.velocity.linear) &&
         same(a.velocity.angular, b.velocity.angular);
}

void write_obstacles(const std::vector<world::Obstacle>& obstacles, msg::PlannerTick& message) {
  message.has_obstacles(true);
  for (const world::Obstacle& obstacle : obstacles) {
    message.obstacles().push_back(to_message(obstacle));
    append_frame(obstacle.X_WO, message.obstacle_frames());
    append_frame(obstacle.attachment ? obstacle.attachment->X_TO : world::Pose::Identity(), message.obstacle_frames());
    for (const world::PlacedShape& shape : obstacle.shapes) append_frame(shape.X_BS, message.obstacle_frames());
  }
}

msg::TickScan scan_message(const planner::RangeScan& scan) {
  msg::TickScan message;
  message.sensor(static_cast<std::uint32_t>(scan.sensor));
  message.link(static_cast<std::uint32_t>(scan.link));
  to_message(scan.q, message.q());
  for (const planner::RangeReading& reading : scan.readings) {
    msg::RangeRay& ray = message.rays().emplace_back();
    ray.origin_L(to_message(reading.ray.origin_L));
    ray.direction_L(to_message(reading.ray.direction_L));
    ray.distance(reading.distance);
    ray.hit(reading.hit);
  }
  return message;
}

msg::TickManoeuvre manoeuvre_message(const planner::Manoeuvre& manoeuvre) {
  msg::TickManoeuvre message;
  message.kind(static_cast<msg::TickManoeuvreKind>(manoeuvre.kind));
  message.seed_high(static_cast<std::uint32_t>(manoeuvre.seed >> 32U));
  message.seed_low(static_cast<std::uint32_t>(manoeuvre.seed));
  to_message(manoeuvre.q, message.q());
  message.time_limit(manoeuvre.time_limit);
  return message;
}

msg::TickRoute route_message(const planner::RouteAnswer& answer) {
  msg::TickRoute message;
  message.kind(static_cast<msg::TickRouteKind>(answer.kind));
  message.points(static_cast<std::uint32_t>(answer.points.size()));
  for (const planner::JointPoint& point : answer.points) {
    if (message.joints().empty()) {
      for (const planner::JointVector& q : point) message.joints().push_back(static_cast<std::uint32_t>(q.size()));
    }
    for (const planner::JointVector& q : point) message.q().insert(message.q().end(), q.begin(), q.end());
  }
  return message;
}

msg::TickPlan plan_message(int arm, const planner::CoupledPlan* plan) {
  msg::TickPlan message;
  message.arm(static_cast<std::uint32_t>(arm));
  if (plan == nullptr) return message;
  message.number(plan->number);
  for (const int one : plan->arms) message.arms().push_back(static_cast<std::uint32_t>(one));
  message.points(static_cast<std::uint32_t>(plan->points.size()));
  for (const auto& point : plan->points) {
    for (const planner::JointVector& q : point) message.q().insert(message.q().end(), q.begin(), q.end());
  }
  return message;
}

msg::TickArm arm_message(int index, const planner::ArmObservation& seen) {
  msg::TickArm message;
  message.arm(static_cast<std::uint32_t>(index));
  message.known(seen.known);
  message.plans(seen.plans);
  message.foreign(seen.foreign);
  message.has_goal(seen.has_goal);
  to_message(seen.q, message.q());
  to_message(seen.qd, message.qd());
  message.age(seen.age);
  to_message(seen.q_goal, message.q_goal());
  message.priority(seen.priority);
  to_message(seen.position_uncertainty, message.position_uncertainty());
  message.proposer(seen.progress.proposer);
  message.number(seen.progress.number);
  message.reached(seen.progress.reached);
  message.speed(seen.speed);
  return message;
}

}  // namespace

TickWriter::TickWriter(std::string arm, int self, std::string node) : self_(self) {
  message_.arm(std::move(arm));
  message_.node(std::move(node));
}

void TickWriter::begin(std::int64_t stamp_ns, const planner::PeriodEvents& events,
                       const std::optional<Snapshot>& snapshot) {
  msg::PlannerTick message;
  message.arm(std::move(message_.arm()));
  message.node(std::move(message_.node()));
  message.sequence_number(message_.sequence_number() + 1);
  message.stamp_ns(stamp_ns);
  if (snapshot) {
    states_.clear();
    proposals_.clear();
    message.snapshot(true);
    message.program(snapshot->program);
    planner::MemoryArchive options;
    planner::ArmPlannerOptions(snapshot->options).describe(options);
    message.options(options.take_words());
    message.memory(snapshot->memory);
  }
  message.missed(events.missed);
  message.drops_setpoint(events.drops_setpoint);
  const planner::SharedObstacles& obstacles = snapshot ? snapshot->obstacles : events.obstacles;
  if (obstacles) {
    states_.clear();
    write_obstacles(*obstacles, message);
  }
  if (events.goal) {
    message.changes_goal(true);
    if (events.goal->q_goal) to_message(*events.goal->q_goal, message.q_goal());
    if (events.goal->trajectory) message.trajectory().push_back(to_message(*events.goal->trajectory));
    message.trajectory_time(events.goal->trajectory_time);
  }
  for (const planner::RangeScan& scan : events.scans) message.scans().push_back(scan_message(scan));
  message_ = std::move(message);
}

void TickWriter::finish(const planner::PeriodInputs& inputs, const planner::TickResult& result) {
  message_.planned(true);
  msg::TickFeedback& own = message_.own();
  to_message(inputs.own.state.q, own.q());
  to_message(inputs.own.state.qd, own.qd());
  own.age(inputs.own.age);
  own.follows(inputs.own.follows);
  own.setpoint(inputs.own.setpoint);
  own.setpoint_age(inputs.own.setpoint_age);
  own.tracking_delay(inputs.own.tracking_delay);
  own.speed_scaling(inputs.own.speed_scaling);
  write_arms(inputs.arms);
  write_obstacle_states(inputs.obstacles);
  message_.hold(inputs.hold);
  message_.speed(inputs.speed);
  message_.commands(inputs.commands);
  message_.number(inputs.number);
  const auto& [rollout, route, coupled_plan] = inputs.answers;
  if (rollout) message_.rollout().push_back(manoeuvre_message(rollout->manoeuvre));
  if (route) message_.route().push_back(route_message(*route));
  if (coupled_plan) message_.coupled_plan().push_back(route_message(*coupled_plan));
  to_message(result.q, message_.q());
  to_message(result.qd, message_.qd());
}

void TickWriter::write_arms(std::span<const planner::ArmObservation> arms) {
  proposals_.resize(arms.size());
  for (int i = 0; i < static_cast<int>(arms.size()); ++i) {
    if (i == self_) continue;
    message_.arms().push_back(arm_message(i, arms[i]));
    if (arms[i].proposal == proposals_[i]) continue;
    proposals_[i] = arms[i].proposal;
    message_.proposals().push_back(plan_message(i, arms[i].proposal.get()));
  }
}

void TickWriter::write_obstacle_states(std::span<const world::ObstacleState> states) {
  const bool all = states_.size() != states.size();
  states_.resize(states.size());
  bool one_age = true;
  for (std::size_t i = 0; i < states.size(); ++i) {
    one_age = one_age && states[i].age == states[0].age;
    if (!all && same_bits(states[i], states_[i])) continue;
    states_[i] = states[i];
    msg::TickObstacle& obstacle = message_.obstacle_states().emplace_back();
    obstacle.obstacle(static_cast<std::uint32_t>(i));
    append_frame(states[i].X_WO, obstacle.X_WO());
    obstacle.velocity(to_message(states[i].velocity));
  }
  for (const world::ObstacleState& state : states) {
    message_.obstacle_ages().push_back(state.age);
    if (one_age) break;
  }
}

}  // namespace hecaton::services
