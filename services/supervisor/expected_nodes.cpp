#include "services/supervisor/expected_nodes.hpp"

#include <algorithm>
#include <chrono>
#include <set>

#include "services/bus/rediscovery.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/state_period.hpp"

namespace hecaton::services {
namespace {

using namespace std::chrono_literals;

/// Loading a cell with large meshes takes seconds on a busy machine.
constexpr Time kGrace = 10s;
constexpr Time kRecovery = 100ms;
/// Margin of rediscovery on a busy machine, or when the kernel must resolve addresses again (5.5 s measured in all).
constexpr Time kLateRediscovery = 1700ms;
/// Margin for last states that are lost and last commands that come late [s].
constexpr double kLossMargin = 0.02;
/// A stream is silent when this many of its samples are missing.
constexpr int kMissingSamples = 5;

Time periods(double period, int count) {
  return std::chrono::duration_cast<Time>(std::chrono::duration<double>(period * count));
}

}  // namespace

std::vector<std::string> arm_names(const config::CellFile& file) {
  std::vector<std::string> names;
  for (const auto& planned : file.cell.arms) names.push_back(planned.arm.name);
  return names;
}

std::vector<ExpectedNode> expected_nodes(const config::CellFile& file, const std::string& self) {
  std::vector<ExpectedNode> nodes;
  std::set<std::string> hosts{file.world_host};
  for (const PlacedNode& supervisor : supervisors_of(file)) {
    hosts.insert(supervisor.host);
    if (supervisor.node != self)
      nodes.push_back({supervisor.node, msg::NodeKind::NODE_SUPERVISOR, {}, supervisor.host});
  }
  nodes.push_back({world_node(), msg::NodeKind::NODE_WORLD, {}, file.world_host});
  const std::vector<std::string> arms = arm_names(file);
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const std::string& host = file.arm_hosts[i].host;
    nodes.push_back({driver_node(arms[i]), msg::NodeKind::NODE_DRIVER, arms[i], host});
    hosts.insert(host);
    for (const PlacedNode& planner : planners_of(file, i)) {
      nodes.push_back({planner.node, msg::NodeKind::NODE_PLANNER, arms[i], planner.host});
      hosts.insert(planner.host);
    }
  }
  for (const std::string& host : hosts) nodes.push_back({agent_node(host), msg::NodeKind::NODE_AGENT, {}, host});
  return nodes;
}

std::vector<ArmPlanners> arms_with_standby(const config::CellFile& file) {
  std::vector<ArmPlanners> arms;
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const auto planners = planners_of(file, i);
    if (planners.size() == 1) continue;
    ArmPlanners& arm = arms.emplace_back();
    arm.arm = file.cell.arms[i].arm.name;
    for (const PlacedNode& planner : planners) arm.planners.push_back(planner.node);
  }
  return arms;
}

// A driver follows its last command until the command timeout.
double braking_delay_of_dead(const config::CellFile& file) {
  return kLossMargin + file.cell.timing.command_timeout;
}

// The planner holds in the period after it notices: it receives no other arm, or the supervisor's hold reaches it.
double braking_delay_of_cut_off(const config::CellFile& file) {
  double noticed_after = std::chrono::duration<double>(file.supervision.heartbeat_deadline).count();
  for (const planner::PlannedArm& planned : file.cell.arms) {
    noticed_after = std::max(noticed_after, planned.parameters.state_age_limit);
  }
  return noticed_after + 2.0 * file.cell.timing.control_period + braking_delay_of_dead(file);
}

DetectionLimits detection_limits(const config::CellFile& file, Time loop_period) {
  const config::Supervision& supervision = file.supervision;
  DetectionLimits limits;
  limits.loop_period = loop_period;
  limits.loop_limit = 2 * loop_period + 2ms;
  limits.heartbeat_period = supervision.heartbeat_period;
  limits.node = {supervision.heartbeat_deadline, supervision.host_lease, kGrace, kRecovery};
  limits.host_lease = supervision.host_lease;
  limits.rediscovery = bus::longest_rediscovery(file.network.lease) + kLateRediscovery;
  limits.sure_return = bus::stable_contact(file.network.lease);
  limits.arm_stream = std::max(supervision.heartbeat_deadline, periods(state_period(file), kMissingSamples));
  limits.world_stream =
      std::max(supervision.heartbeat_deadline, periods(file.cell.timing.world_period, kMissingSamples));
  limits.arm_period = periods(state_period(file), 1);
  limits.world_period = periods(file.cell.timing.world_period, 1);
  for (const std::string& kind : supervision.waits_for_resume) limits.waits_for_resume.insert(cause_kind(kind).value());
  return limits;
}

}  // namespace hecaton::services
