#include "services/tick_log/tick_reader.hpp"

#include <algorithm>
#include <utility>

#include "services/messages/convert.hpp"

namespace hecaton::services {
namespace {

constexpr std::size_t kFrame = 12;  ///< numbers of a frame, see TickObstacle::X_WO

void read_frame(std::span<const double> numbers, world::Pose& pose) {
  pose = world::Pose::Identity();
  for (int i = 0; i < static_cast<int>(kFrame); ++i) pose.matrix()(i % 3, i / 3) = numbers[static_cast<std::size_t>(i)];
}

Eigen::Vector3d vector_of(const msg::Vec3& message) {
  return {message.x(), message.y(), message.z()};
}

}  // namespace

TickReader::TickReader(const planner::Cell& cell, int self) : cell_(cell), self_(self), arms_(cell.arms.size()) {
  for (const planner::PlannedArm& planned : cell.arms) joints_.push_back(planned.arm.model->joints());
}

std::optional<std::string> TickReader::take(const msg::PlannerTick& message) {
  if (message.snapshot()) {
    arms_.assign(arms_.size(), {});
    states_.clear();
    obstacles_ = 0;
  }
  if (auto error = take_events(message)) return error;
  return message.planned() ? take_inputs(message) : std::nullopt;
}

TickReader::Error TickReader::take_events(const msg::PlannerTick& message) {
  events_ = {};
  events_.missed = message.missed();
  events_.drops_setpoint = message.drops_setpoint();
  if (message.has_obstacles()) {
    if (auto error = take_obstacles(message)) return error;
  }
  if (message.changes_goal()) {
    planner::GoalChange change;
    planner::JointVector q_goal;
    if (!read(message.q_goal(), joints_[self_], true, q_goal)) return "q_goal does not fit the arm";
    if (q_goal.size() > 0) change.q_goal = q_goal;
    if (message.trajectory().size() > 1) return "it has two trajectories";
    for (const msg::TimedTrajectory& described : message.trajectory()) {
      auto trajectory = messages::from_message(described, "trajectory", joints_[self_]);
      if (!trajectory) return trajectory.error;
      change.trajectory = std::make_shared<const planner::TimedTrajectory>(std::move(*trajectory.value));
    }
    change.trajectory_time = message.trajectory_time();
    events_.goal = change;
  }
  scans_.clear();
  const planner::PlannedArm& own = cell_.arms[self_];
  for (const msg::TickScan& scan : message.scans()) {
    planner::RangeScan& taken = scans_.emplace_back();
    taken.sensor = static_cast<int>(scan.sensor());
    taken.link = static_cast<int>(scan.link());
    const bool known = scan.sensor() < own.sensors.size() && scan.link() < own.arm.model->links.size();
    if (!known || !read(scan.q(), joints_[self_], false, taken.q)) return "a scan does not fit the arm";
    for (const msg::RangeRay& ray : scan.rays()) {
      taken.readings.push_back({{vector_of(ray.origin_L()), vector_of(ray.direction_L())}, ray.distance(), ray.hit()});
    }
  }
  events_.scans = scans_;
  return std::nullopt;
}

TickReader::Error TickReader::take_obstacles(const msg::PlannerTick& message) {
  auto obstacles = std::make_shared<std::vector<world::Obstacle>>();
  std::span<const double> frames(message.obstacle_frames());
  for (const msg::Obstacle& described : message.obstacles()) {
    auto obstacle = messages::from_message(described);
    if (!obstacle) return obstacle.error;
    world::Obstacle& taken = obstacles->emplace_back(std::move(*obstacle.value));
    if (frames.size() < kFrame * (2 + taken.shapes.size())) return "frames of obstacles are missing";
    const auto next = [&](world::Pose& pose) {
      read_frame(frames, pose);
      frames = frames.subspan(kFrame);
    };
    next(taken.X_WO);
    world::Pose X_TO;
    next(X_TO);
    for (world::PlacedShape& shape : taken.shapes) next(shape.X_BS);
    if (!taken.attachment) continue;
    taken.attachment->X_TO = X_TO;
    const bool known = std::any_of(cell_.arms.begin(), cell_.arms.end(),
                                   [&](const auto& planned) { return planned.arm.name == taken.attachment->arm; });
    if (!known) return "obstacle " + taken.name + " is attached to no arm of the cell";
  }
  obstacles_ = obstacles->size();
  states_.clear();
  events_.obstacles = std::move(obstacles);
  return std::nullopt;
}

TickReader::Error TickReader::take_inputs(const msg::PlannerTick& message) {
  const msg::TickFeedback& own = message.own();
  inputs_ = {};
  const bool measured = read(own.q(), joints_[self_], false, inputs_.own.state.q) &&
                        read(own.qd(), joints_[self_], false, inputs_.own.state.qd);
  if (!measured) return "the measured state does not fit the arm";
  inputs_.own.age = own.age();
  inputs_.own.follows = own.follows();
  inputs_.own.setpoint = own.setpoint();
  inputs_.own.setpoint_age = own.setpoint_age();
  inputs_.own.tracking_delay = own.tracking_delay();
  inputs_.own.speed_scaling = own.speed_scaling();
  if (auto error = take_arms(message)) return error;
  if (auto error = take_obstacle_states(message)) return error;
  inputs_.hold = message.hold();
  inputs_.speed = message.speed();
  inputs_.commands = message.commands();
  inputs_.number = message.number();
  if (message.rollout().size() > 1 || message.route().size() > 1 || message.coupled_plan().size() > 1) {
    return "it has two answers of one search";
  }
  for (const msg::TickManoeuvre& found : message.rollout()) {
    planner::Manoeuvre& manoeuvre = inputs_.answers.rollout.emplace().manoeuvre;
    manoeuvre.kind = static_cast<planner::ManoeuvreKind>(found.kind());
    manoeuvre.seed = static_cast<std::uint64_t>(found.seed_high()) << 32U | found.seed_low();
    if (!read(found.q(), joints_[self_], true, manoeuvre.q)) return "a manoeuvre does not fit the arm";
    manoeuvre.time_limit = found.time_limit();
  }
  for (const msg::TickRoute& found : message.route()) {
    const bool fits = read(found, inputs_.answers.route.emplace()) && found.joints().size() <= 1 &&
                      (found.joints().empty() || static_cast<int>(found.joints()[0]) == joints_[self_]);
    if (!fits) return "a route does not fit the arm";
  }
  for (const msg::TickRoute& found : message.coupled_plan()) {
    if (!read(found, inputs_.answers.coupled_plan.emplace())) return "a coupled plan does not fit the arms";
  }
  return std::nullopt;
}

TickReader::Error TickReader::take_arms(const msg::PlannerTick& message) {
  const int count = static_cast<int>(arms_.size());
  if (message.arms().size() + 1 != arms_.size()) return "it has not all arms of the cell";
  for (const msg::TickArm& seen : message.arms()) {
    const auto index = static_cast<int>(seen.arm());
    if (index >= count || index == self_) return "it has an arm that the cell does not have";
    planner::ArmObservation& arm = arms_[index];
    const bool fits = read(seen.q(), joints_[index], !seen.known(), arm.q) &&
                      read(seen.qd(), joints_[index], !seen.known(), arm.qd) &&
                      read(seen.q_goal(), joints_[index], !seen.has_goal(), arm.q_goal) &&
                      read(seen.position_uncertainty(), joints_[index], true, arm.position_uncertainty) &&
                      seen.proposer() >= -1 && seen.proposer() < count;
    if (!fits) return "the state of arm " + cell_.arms[index].arm.name + " does not fit the arm";
    arm.known = seen.known();
    arm.plans = seen.plans();
    arm.foreign = seen.foreign();
    arm.has_goal = seen.has_goal();
    arm.age = seen.age();
    arm.priority = seen.priority();
    arm.progress = {seen.proposer(), seen.number(), seen.reached()};
    arm.speed = seen.speed();
  }
  for (const msg::TickPlan& changed : message.proposals()) {
    const auto index = static_cast<int>(changed.arm());
    if (index >= count || index == self_) return "it has a proposal of an arm that the cell does not have";
    arms_[index].proposal = nullptr;
    if (changed.arms().empty()) continue;
    auto plan = std::make_shared<planner::CoupledPlan>();
    plan->number = changed.number();
    std::size_t joints = 0;
    for (const std::uint32_t arm : changed.arms()) {
      if (static_cast<int>(arm) >= count) return "it has a proposal for an arm that the cell does not have";
      plan->arms.push_back(static_cast<int>(arm));
      joints += static_cast<std::size_t>(joints_[static_cast<int>(arm)]);
    }
    if (changed.q().size() != joints * changed.points()) return "a proposal does not fit its arms";
    auto from = changed.q().begin();
    for (std::uint32_t point = 0; point < changed.points(); ++point) {
      auto& at = plan->points.emplace_back();
      for (const int arm : plan->arms) {
        at.emplace_back(Eigen::Map<const Eigen::VectorXd>(&*from, joints_[arm]));
        from += joints_[arm];
      }
    }
    arms_[index].proposal = std::move(plan);
  }
  inputs_.arms = arms_;
  return std::nullopt;
}

TickReader::Error TickReader::take_obstacle_states(const msg::PlannerTick& message) {
  const bool first = states_.empty();
  states_.resize(obstacles_);
  std::size_t set = 0;
  for (const msg::TickObstacle& moved : message.obstacle_states()) {
    if (moved.obstacle() >= obstacles_ || moved.X_WO().size() != kFrame) return "it has the state of no obstacle";
    world::ObstacleState& state = states_[moved.obstacle()];
    read_frame(moved.X_WO(), state.X_WO);
    state.velocity = {vector_of(moved.velocity().linear()), vector_of(moved.velocity().angular())};
    ++set;
  }
  if (first && set != obstacles_) return "states of obstacles are missing";
  const auto& ages = message.obstacle_ages();
  if (ages.size() != obstacles_ && (ages.size() != 1 || obstacles_ == 0)) return "ages of obstacles are missing";
  for (std::size_t i = 0; i < obstacles_; ++i) states_[i].age = ages.size() == 1 ? ages[0] : ages[i];
  inputs_.obstacles = states_;
  return std::nullopt;
}

bool TickReader::read(const std::vector<double>& values, int joints, bool may_be_empty, planner::JointVector& q) {
  const bool fits = static_cast<int>(values.size()) == joints || (may_be_empty && values.empty());
  if (fits) q = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  return fits;
}

bool TickReader::read(const msg::TickRoute& message, planner::RouteAnswer& answer) const {
  answer.kind = static_cast<planner::RouteAnswer::Kind>(message.kind());
  std::size_t joints = 0;
  for (const std::uint32_t of_arm : message.joints()) {
    if (of_arm == 0 || of_arm > static_cast<std::uint32_t>(planner::kMaxJoints)) return false;
    joints += of_arm;
  }
  if (message.q().size() != joints * message.points()) return false;
  if (message.points() > 0 && joints == 0) return false;
  const double* from = message.q().data();
  for (std::uint32_t point = 0; point < message.points(); ++point) {
    planner::JointPoint& at = answer.points.emplace_back();
    for (const std::uint32_t of_arm : message.joints()) {
      at.emplace_back(Eigen::Map<const Eigen::VectorXd>(from, static_cast<Eigen::Index>(of_arm)));
      from += of_arm;
    }
  }
  return true;
}

std::unique_ptr<planner::ArmPlanner> TickReader::planner(const msg::PlannerTick& snapshot) const {
  planner::ArmPlannerOptions options;
  planner::MemoryArchive archive(snapshot.options(), static_cast<int>(arms_.size()), joints_[self_]);
  options.describe(archive);
  if (!archive.complete() || !(options.control_period > 0.0 && options.control_period <= 10.0)) return nullptr;
  auto planner = std::make_unique<planner::ArmPlanner>(planner::CellGeometry(arms_of(cell_), self_),
                                                       cell_.arms[self_].parameters, options);
  if (!snapshot.memory().empty() && !planner->restore(snapshot.memory())) return nullptr;
  return planner;
}

}  // namespace hecaton::services
