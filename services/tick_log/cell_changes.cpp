#include "services/tick_log/cell_changes.hpp"

#include <nlohmann/json.hpp>

namespace hecaton::services {

std::optional<std::string> CellChanges::apply(planner::Cell& cell) const {
  for (planner::PlannedArm& planned : cell.arms) {
    if (rollouts >= 0) planned.parameters.rollout.candidates = rollouts;
    if (no_routes) planned.parameters.replanning.stall_timeout = 0.0;
    if (no_routes) planned.parameters.coordination.stall_timeout = 0.0;
    if (!method.empty()) {
      if (!planned.select_method(method)) return method + " is no motion method";
      if (auto objection = planned.objection()) return objection;
    }
    for (int j = 0; speed > 0.0 && j < planned.arm.model->joints(); ++j) {
      if (planner::joint_type(*planned.arm.model, j) != planner::JointType::kPrismatic) {
        planned.arm.limits.velocity[j] = speed;
      }
    }
  }
  return std::nullopt;
}

std::string CellChanges::json() const {
  return nlohmann::json{{"method", method}, {"rollouts", rollouts}, {"no_routes", no_routes}, {"speed", speed}}.dump();
}

std::optional<CellChanges> CellChanges::from_json(std::string_view text) {
  const auto json = nlohmann::json::parse(text, nullptr, false);
  try {
    return CellChanges{json.at("method"), json.at("rollouts"), json.at("no_routes"), json.at("speed")};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace hecaton::services
