#include "services/supervisor/cell_status.hpp"

#include <algorithm>
#include <chrono>

#include "services/messages/names.hpp"
#include "services/runtime/node_name.hpp"
#include "services/supervisor/expected_nodes.hpp"
#include "services/supervisor/messages.hpp"
#include "services/supervisor/waiting_for.hpp"

namespace hecaton::services {
namespace {

constexpr double kNever = -1.0;            // age of what was never heard [s]
constexpr std::size_t kClearedShown = 32;  // faults that are over, in a reply

msg::NodeKind kind_of(NodeRole role) {
  switch (role) {
    case NodeRole::kPlanner:
      return msg::NodeKind::NODE_PLANNER;
    case NodeRole::kDriver:
      return msg::NodeKind::NODE_DRIVER;
    case NodeRole::kWorld:
      return msg::NodeKind::NODE_WORLD;
    case NodeRole::kSupervisor:
      return msg::NodeKind::NODE_SUPERVISOR;
    case NodeRole::kAgent:
      break;
  }
  return msg::NodeKind::NODE_AGENT;
}

class StatusBuilder {
 public:
  StatusBuilder(const StatusSource& source, const Clocks& clocks)
      : source_(source), clocks_(clocks), now_(clocks.now) {}

  msg::CellStatus build() {
    status_.cell(source_.file.cell.name);
    status_.mode(source_.mode);
    status_.supervisor(source_.mode.node());
    for (const ExpectedNode& node : source_.watch.nodes()) {
      if (node.role == NodeRole::kSupervisor && stands_by(node.name)) status_.standby(node.name);
    }
    for (const std::string& arm : arm_names(source_.file)) add_arm(arm);
    add_nodes();
    for (const config::Host& host : source_.file.hosts) add_host(host.name);
    add_faults();
    add_referee();
    add_obstacles();
    return status_;
  }

 private:
  template <class T>
  [[nodiscard]] double age(const Heard<T>& heard) const {
    return std::max(0.0, heard.age(now_));
  }

  void add_arm(const std::string& name) {
    const FaultDetector& watch = source_.watch;
    msg::ArmStatus arm;
    arm.arm(name);
    arm.mode(mode_of(watch.mode().mode_of(name)));
    arm.driver_alive(watch.alive(driver_node(name)));
    const std::string planner = watch.in_charge(name);
    arm.planner_alive(watch.alive(planner));
    if (find(source_.picture.heartbeats, planner)) arm.planner(planner);
    arm.term(source_.mode.term());
    if (const ArmPlanners* planners = source_.succession.planners_of(name)) {
      arm.term(source_.succession.mandate_of(name).term);
      for (const std::string& other : planners->planners) {
        if (other != planner && stands_by(other)) arm.standby(other);
      }
    }
    arm.state().arm(name);
    arm.state_age(kNever);
    arm.goal_age(kNever);
    if (const auto* state = find(source_.picture.arms, name)) {
      arm.state(state->value);
      arm.state_age(age(*state));
    }
    if (const auto* goal = find(source_.picture.goals, name)) {
      arm.has_goal(true);
      arm.goal(goal->value);
      arm.goal_age(age(*goal));
    }
    arm.waiting_for(waiting_for(name, watch, source_.picture));
    status_.arms().push_back(std::move(arm));
  }

  [[nodiscard]] bool stands_by(const std::string& node) const {
    const auto* heartbeat = find(source_.picture.heartbeats, node);
    return heartbeat && heartbeat->value.state() == msg::NodeState::NODE_STANDBY && source_.watch.alive(node);
  }

  [[nodiscard]] bool alive(const Heard<msg::Heartbeat>& heartbeat) const {
    const std::string& node = heartbeat.value.node();
    if (source_.watch.expects(node)) return source_.watch.alive(node);
    return age(heartbeat) <= std::chrono::duration<double>(source_.file.supervision.host_lease).count();
  }

  void add_nodes() {
    for (const auto& [name, heartbeat] : source_.picture.heartbeats) {
      msg::NodeStatus node;
      node.heartbeat(heartbeat.value);
      node.age(age(heartbeat));
      node.alive(alive(heartbeat));
      status_.nodes().push_back(std::move(node));
    }
    for (const ExpectedNode& expected : source_.watch.nodes()) {
      if (find(source_.picture.heartbeats, expected.name)) continue;
      msg::NodeStatus node;
      node.heartbeat().node(expected.name);
      node.heartbeat().kind(kind_of(expected.role));
      node.heartbeat().subject(expected.arm);
      node.heartbeat().host(expected.host);
      node.heartbeat().detail(source_.watch.awaited(expected.name));
      node.age(kNever);
      status_.nodes().push_back(std::move(node));
    }
  }

  void add_host(const std::string& name) {
    msg::HostStatus host;
    host.host(name);
    host.agent_alive(source_.watch.alive(agent_node(name)));
    host.age(kNever);
    for (const auto& [node, heartbeat] : source_.picture.heartbeats) {
      if (heartbeat.value.host() != name) continue;
      host.age(host.age() < 0.0 ? age(heartbeat) : std::min(host.age(), age(heartbeat)));
    }
    for (const auto& [process, event] : source_.picture.processes) {
      if (event.value.host() == name) host.processes().push_back(event.value);
    }
    status_.hosts().push_back(std::move(host));
  }

  void add_faults() {
    const auto& faults = source_.watch.faults();
    const auto add = [&](const FaultRecord& record) {
      status_.faults().push_back(fault_message(record, clocks_));
      status_.faults().back().term(source_.mode.term());
    };
    for (const FaultRecord& record : faults.open()) add(record);
    const auto& over = faults.over();
    std::for_each(over.begin(), over.begin() + static_cast<long>(std::min(over.size(), kClearedShown)), add);
  }

  void add_referee() {
    status_.referee_age(kNever);
    if (!source_.picture.referee) return;
    status_.has_referee(true);
    status_.referee(source_.picture.referee->value);
    status_.referee_age(age(*source_.picture.referee));
  }

  void add_obstacles() {
    for (const auto& [name, shapes] : source_.picture.obstacles) {
      const msg::Obstacle& obstacle = shapes.value.obstacle();
      msg::ObstacleStatus status;
      status.name(name);
      status.shape(shape_list(obstacle));
      status.motion(text(obstacle.motion().kind()));
      status.attached_to(obstacle.attached_to());
      status.X_WO(obstacle.X_WO());
      status.age(kNever);
      add_state(status);
      status_.obstacles().push_back(std::move(status));
    }
  }

  void add_state(msg::ObstacleStatus& status) {
    if (!source_.picture.states) return;
    const auto& states = source_.picture.states->value.states();
    const auto state =
        std::find_if(states.begin(), states.end(), [&](const auto& s) { return s.name() == status.name(); });
    if (state == states.end()) return;
    status.X_WO(state->X_WO());
    status.velocity(state->velocity());
    status.age(age(*source_.picture.states));
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

msg::CellStatus cell_status(const StatusSource& source, const Clocks& clocks) {
  return StatusBuilder(source, clocks).build();
}

}  // namespace hecaton::services
