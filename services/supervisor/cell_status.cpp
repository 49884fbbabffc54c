#include "services/supervisor/cell_status.hpp"

#include <algorithm>
#include <chrono>

#include "planner/trajectory/stop_profile.hpp"
#include "services/messages/names.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/standstill.hpp"
#include "services/runtime/state_age.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/clipped_text.hpp"
#include "services/supervisor/expected_nodes.hpp"

namespace hecaton::services {
namespace {

constexpr double kNever = -1.0;               // age of what was never received [s]
constexpr std::size_t kClearedShown = 32;     // cleared faults in a reply
constexpr std::size_t kLongestRefusal = 300;  // its text [byte]

msg::Cause first_awaited(const std::string& arm, const FaultDetector& detector) {
  for (const std::string& node : {driver_node(arm), detector.in_charge(arm), world_node()}) {
    if (msg::Cause awaited = detector.awaited(node); !is_none(awaited)) return awaited;
  }
  return {};
}

class StatusBuilder {
 public:
  StatusBuilder(const StatusSource& source, const Clocks& clocks)
      : source_(source), clocks_(clocks), now_(clocks.now) {}

  msg::CellStatus build() {
    status_.cell(source_.file.cell.name);
    status_.mode(source_.mode);
    status_.supervisor(source_.mode.node());
    for (const ExpectedNode& node : source_.detector.nodes()) {
      if (node.role == msg::NodeKind::NODE_SUPERVISOR && stands_by(node.name)) status_.standby(node.name);
    }
    for (const std::string& arm : arm_names(source_.file)) add_arm(arm);
    add_nodes();
    for (const config::Host& host : source_.file.hosts) add_host(host.name);
    add_faults();
    add_contact_report();
    add_obstacles();
    return status_;
  }

 private:
  template <class T>
  [[nodiscard]] double age(const Received<T>& sample) const {
    return std::max(0.0, sample.age(now_));
  }

  void add_arm(const std::string& name) {
    const FaultDetector& detector = source_.detector;
    msg::ArmStatus arm;
    arm.arm(name);
    arm.mode(detector.mode().mode_of(name));
    arm.speed(detector.mode().speed_of(name));
    arm.driver_alive(detector.alive(driver_node(name)));
    const std::string planner = detector.in_charge(name);
    arm.planner_alive(detector.alive(planner));
    if (find(source_.snapshot.heartbeats, planner)) arm.planner(planner);
    arm.term(source_.mode.term());
    if (const ArmPlanners* planners = source_.failover.planners_of(name)) {
      arm.term(source_.failover.lease(name).term);
      for (const std::string& other : planners->planners) {
        if (other != planner && stands_by(other)) arm.standby(other);
      }
    }
    arm.state().arm(name);
    arm.state_age(kNever);
    arm.goal_age(kNever);
    if (const auto* state = find(source_.snapshot.arms, name)) {
      arm.state(state->value);
      arm.state().cause().text() = clipped(state->value.cause().text());
      arm.state().carried() = clipped(state->value.carried());
      arm.state_age(std::max(age(*state), std::chrono::duration<double>(least_age(state->value)).count()));
    }
    if (const auto* goal = find(source_.snapshot.goals, name)) {
      arm.has_goal(true);
      arm.goal(goal->value);
      arm.goal().cause().text() = clipped(goal->value.cause().text());
      arm.goal().note() = clipped(goal->value.note());
      arm.goal().recovery_action() = clipped(goal->value.recovery_action());
      arm.goal_age(age(*goal));
    }
    arm.waiting_for(waiting_for(name, detector, source_.snapshot));
    arm.waiting_for().text() = clipped(arm.waiting_for().text());
    status_.arms().push_back(std::move(arm));
  }

  [[nodiscard]] bool stands_by(const std::string& node) const {
    const auto* heartbeat = find(source_.snapshot.heartbeats, node);
    return heartbeat && heartbeat->value.state() == msg::NodeState::NODE_STANDBY && source_.detector.alive(node);
  }

  [[nodiscard]] bool alive(const Received<msg::Heartbeat>& heartbeat) const {
    const std::string& node = heartbeat.value.node();
    if (source_.detector.expects(node)) return source_.detector.alive(node);
    return age(heartbeat) <= std::chrono::duration<double>(source_.file.supervision.host_lease).count();
  }

  void add_nodes() {
    for (const auto& [name, heartbeat] : source_.snapshot.heartbeats) {
      msg::NodeStatus node;
      node.heartbeat(heartbeat.value);
      node.heartbeat().cause().text() = clipped(heartbeat.value.cause().text());
      node.heartbeat().oldest_input() = clipped(heartbeat.value.oldest_input());
      for (msg::Refusal& refusal : node.heartbeat().refusals()) {
        refusal.cause().text() = clipped(refusal.cause().text(), kLongestRefusal);
      }
      node.age(age(heartbeat));
      node.alive(alive(heartbeat));
      status_.nodes().push_back(std::move(node));
    }
    for (const ExpectedNode& expected : source_.detector.nodes()) {
      if (find(source_.snapshot.heartbeats, expected.name)) continue;
      msg::NodeStatus node;
      node.heartbeat().node(expected.name);
      node.heartbeat().kind(expected.role);
      node.heartbeat().subject(expected.arm);
      node.heartbeat().host(expected.host);
      node.heartbeat().cause(source_.detector.awaited(expected.name));
      node.age(kNever);
      status_.nodes().push_back(std::move(node));
    }
  }

  void add_host(const std::string& name) {
    msg::HostStatus host;
    host.host(name);
    host.agent_alive(source_.detector.alive(agent_node(name)));
    host.age(kNever);
    for (const auto& [node, heartbeat] : source_.snapshot.heartbeats) {
      if (heartbeat.value.host() != name) continue;
      host.age(host.age() < 0.0 ? age(heartbeat) : std::min(host.age(), age(heartbeat)));
    }
    for (const auto& [process, event] : source_.snapshot.processes) {
      if (event.value.host() == name) host.processes().push_back(event.value);
    }
    status_.hosts().push_back(std::move(host));
  }

  void add_faults() {
    const auto& faults = source_.detector.faults();
    const auto add = [&](const FaultRecord& record) {
      status_.faults().push_back(fault_message(record, clocks_));
      status_.faults().back().term(source_.mode.term());
    };
    for (const FaultRecord& record : faults.open()) add(record);
    const auto& cleared = faults.cleared();
    std::for_each(cleared.begin(), cleared.begin() + static_cast<long>(std::min(cleared.size(), kClearedShown)), add);
  }

  void add_contact_report() {
    status_.contact_report_age(kNever);
    if (!source_.snapshot.contact_report) return;
    status_.has_contact_report(true);
    status_.contact_report(source_.snapshot.contact_report->value);
    status_.contact_report_age(age(*source_.snapshot.contact_report));
  }

  void add_obstacles() {
    for (const auto& [name, shapes] : source_.snapshot.obstacles) {
      const auto& states = source_.snapshot.states;
      if (states && !shapes.writer.same_participant(states->writer) && state_of(name) == nullptr) continue;  // forged
      const msg::Obstacle& obstacle = shapes.value.obstacle();
      msg::ObstacleStatus status;
      status.name(name);
      status.shape(clipped(shape_list(obstacle)));
      status.motion(text(obstacle.motion().kind()));
      status.attached_to(obstacle.attached_to());
      status.X_WO(obstacle.X_WO());
      status.age(kNever);
      add_state(status);
      status_.obstacles().push_back(std::move(status));
    }
  }

  /// What the world says of an obstacle; null: nothing.
  [[nodiscard]] const msg::ObstacleState* state_of(const std::string& obstacle) const {
    if (!source_.snapshot.states) return nullptr;
    const auto& states = source_.snapshot.states->value.states();
    const auto state = std::find_if(states.begin(), states.end(), [&](const auto& s) { return s.name() == obstacle; });
    return state == states.end() ? nullptr : &*state;
  }

  void add_state(msg::ObstacleStatus& status) {
    const msg::ObstacleState* state = state_of(status.name());
    if (state == nullptr) return;
    status.X_WO(state->X_WO());
    status.velocity(state->velocity());
    status.age(age(*source_.snapshot.states));
  }

  static std::string shape_list(const msg::Obstacle& obstacle) {
    std::string list;
    for (const msg::PlacedShape& shape : obstacle.shapes()) list += (list.empty() ? "" : " + ") + text(shape);
    return list;
  }

  const StatusSource& source_;
  const Clocks& clocks_;
  bus::Clock::time_point now_;
  msg::CellStatus status_;
};

}  // namespace

msg::Cause waiting_for(const std::string& arm, const FaultDetector& detector, const CellSnapshot& snapshot) {
  if (msg::Cause held = detector.mode().cause_of(arm); !is_none(held)) return held;
  if (msg::Cause awaited = first_awaited(arm, detector); !is_none(awaited)) return awaited;
  const auto* state = find(snapshot.arms, arm);
  const auto* goal = find(snapshot.goals, arm);
  // An arm that still brakes after its goal has ended waits for the next goal already.
  if (state && moves(state->value, detector.mode().speed_of(arm)) && !(goal && is_final(goal->value.state())))
    return {};
  const auto* planner = find(snapshot.heartbeats, detector.in_charge(arm));
  if (planner && planner->value.state() == msg::NodeState::NODE_DEGRADED && !is_none(planner->value.cause())) {
    msg::Cause cause = planner->value.cause();
    cause.text(planner->value.node() + ": " + cause.text());
    return cause;
  }
  if (state && state->value.mode() != msg::ArmMode::ARM_RUNNING && !(goal && awaits_goal(state->value, goal->value))) {
    return drive_cause(state->value);
  }
  if (goal) return goal_cause(goal->value);
  const auto* lost = find(snapshot.lost_goals, arm);
  return make_cause(
      msg::CauseKind::CAUSE_NO_GOAL, {},
      lost ? "a goal; " + lost->value.goal() + " was lost with the process of " + lost->value.node() : "a goal");
}

std::optional<std::string> stands_without_reason(const std::string& arm, const FaultDetector& detector,
                                                 const CellSnapshot& snapshot) {
  const auto* state = find(snapshot.arms, arm);
  if (!state || moves(state->value, detector.mode().speed_of(arm))) return std::nullopt;
  const auto* goal = find(snapshot.goals, arm);
  const bool has_goal = goal && !is_final(goal->value.state());
  const msg::Cause cause = waiting_for(arm, detector, snapshot);
  switch (cause.kind()) {
    case msg::CauseKind::CAUSE_NONE:
      if (!has_goal) return std::nullopt;
      return "goal " + goal->value.goal() + " is under way, and nothing holds the arm";
    case msg::CauseKind::CAUSE_COMMANDS_CEASED:
      return has_goal ? std::optional(cause.text()) : std::nullopt;
    case msg::CauseKind::CAUSE_COMMAND_REFUSED:
    case msg::CauseKind::CAUSE_COMMAND_TOO_FAR:
      return cause.text();
    default:
      return std::nullopt;
  }
}

std::vector<msg::LostArm> lost_arms(const config::CellFile& file, const std::vector<bool>& stop_without_driver,
                                    const FaultDetector& detector, const CellSnapshot& snapshot,
                                    bus::Clock::time_point now) {
  std::vector<msg::LostArm> lost;
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    if (!stop_without_driver[i]) continue;
    const planner::PlannedArm& planned = file.cell.arms[i];
    const DriverLoss loss = detector.loss_of_driver(planned.arm.name);
    const auto* last = find(snapshot.arms, planned.arm.name);
    if (loss == DriverLoss::kNone || !last) continue;
    if (snapshot.observed.contains(planned.arm.name)) continue;  // others may move it on
    const double braking_delay =
        (loss == DriverLoss::kEnded ? braking_delay_of_dead(file) : braking_delay_of_cut_off(file)) +
        last->value.tracking_delay();
    if (last->age(now) < braking_delay + planner::longest_stop_time(planned.arm.limits)) continue;
    msg::LostArm& arm = lost.emplace_back();
    arm.arm(planned.arm.name);
    arm.stamp_ns(last->value.stamp_ns());
    arm.q(last->value.q());
    arm.qd(last->value.qd());
    arm.braking_delay_bound(braking_delay);
  }
  return lost;
}

msg::CellStatus cell_status(const StatusSource& source, const Clocks& clocks) {
  return StatusBuilder(source, clocks).build();
}

}  // namespace hecaton::services
