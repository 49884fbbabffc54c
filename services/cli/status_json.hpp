#pragma once
/// The supervisor's picture of a cell for programs. Ages [s] are on the supervisor's clock, null when never heard of.

#include <idl/supervisor.h>

#include "services/command_line/document.hpp"

namespace hecaton::services::cli {

[[nodiscard]] Json to_json(const msg::GoalStatus& goal);
/// Null for CAUSE_NONE.
[[nodiscard]] Json to_json(const msg::Cause& cause);
[[nodiscard]] Json to_json(const msg::ArmStatus& arm);
[[nodiscard]] Json to_json(const msg::NodeStatus& node);
[[nodiscard]] Json to_json(const msg::HostStatus& host);
[[nodiscard]] Json to_json(const msg::Fault& fault);
[[nodiscard]] Json to_json(const msg::ObstacleStatus& obstacle);
[[nodiscard]] Json to_json(const msg::Separation& separation);
[[nodiscard]] Json to_json(const msg::RefereeReport& report);
[[nodiscard]] Json to_json(const msg::LostArm& lost);
[[nodiscard]] Json to_json(const msg::CellMode& mode);
[[nodiscard]] Json to_json(const msg::CellStatus& status);

template <class T>
[[nodiscard]] Json list_json(const std::vector<T>& items) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(to_json(item));
  return list;
}

}  // namespace hecaton::services::cli
