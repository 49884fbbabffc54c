// What stands still because of what is wrong: derived anew in every turn (docs/design/0003-supervision.md, 5).

#include <string>

#include "services/supervisor/cell_watch.hpp"

namespace hecaton::services {

const FaultRecord* CellWatch::fault_holding(const ExpectedNode& node) const {
  if (const FaultRecord* fault = faults_.open(node.name)) return fault;
  if (alive(node.name)) return nullptr;
  const ExpectedNode* agent = hosts_.agent_of(node.host);
  if (const FaultRecord* fault = agent ? faults_.open(agent->name) : nullptr) return fault;
  return hosts_.cut_off() ? faults_.open(hosts_.agent_of(hosts_.own())->name) : nullptr;
}

std::optional<msg::Cause> CellWatch::hold_cause(const ExpectedNode& node) const {
  if (const FaultRecord* fault = fault_holding(node)) return held_by(*fault);
  // Who is not heard had better not move, for it may hear us: also while whose fault it is is not known yet, or it is
  // our own.
  if (!liveness_.last_heard(node.name)) return std::nullopt;
  const bool silent = !alive(node.name) && hosts_.silent_for(node.host, limits_.node.silence);
  if (silent) {
    return make_cause(msg::CauseKind::CAUSE_NODE_SILENT, node.name, "nothing is heard of host " + node.host);
  }
  const bool returns = (hosts_.put_down_to_us(node) && !sound(node)) || (hosts_.explain(node) && !alive(node.name));
  if (!returns) return std::nullopt;
  return make_cause(msg::CauseKind::CAUSE_NODE_SILENT, node.name, node.name + " is not back yet");
}

// What an agent started works without it, everything without the other supervisor, an arm without who stands by for it.
bool CellWatch::holds_arms(const ExpectedNode& node) const {
  if (node.role == msg::NodeKind::NODE_PLANNER) return node.name == in_charge(node.arm);
  return node.role == msg::NodeKind::NODE_DRIVER || node.role == msg::NodeKind::NODE_WORLD;
}

AutomaticHolds CellWatch::holds() const {
  AutomaticHolds holds;
  for (const ExpectedNode& node : nodes_) {
    if (!holds_arms(node)) continue;
    auto cause = hold_cause(node);
    if (!cause) continue;
    if (node.role != msg::NodeKind::NODE_WORLD) {
      holds.arms.try_emplace(node.arm, *std::move(cause));
    } else if (!holds.cell) {
      holds.cell = std::move(cause);
    }
  }
  return holds;
}

}  // namespace hecaton::services
