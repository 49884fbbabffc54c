#pragma once
/// The status of a cell as its supervisor reports it: texts for people, JSON for programs. Ages are on the supervisor's
/// clock [s]; JSON has null for the age of something never received.

#include <map>
#include <string>
#include <vector>

#include <idl/arm.h>
#include <idl/supervisor.h>

#include "services/command_line/document.hpp"
#include "services/command_line/terminal.hpp"
#include "services/messages/names.hpp"

namespace hecaton::services::cli {

/// The newest state of each gripper that was heard, by arm.
using Tools = std::map<std::string, msg::ToolState>;

/// "blocked: no path around pallet (arm2/forearm – pallet, 18 mm); draws another subspace"
[[nodiscard]] std::string goal_text(const msg::GoalStatus& goal);
/// The part after the state: why the goal is in it. Empty without a reason; never empty for a blocked goal.
[[nodiscard]] std::string reason_text(const msg::GoalStatus& goal);
/// Why the arm waits; otherwise why its goal is not reached yet.
[[nodiscard]] std::string waiting_text(const msg::ArmStatus& arm);
/// "0 contacts, smallest separation 31 mm (arm1/wrist – arm2/forearm)"
[[nodiscard]] std::string contact_text(const msg::ContactReport& report, const Palette& palette);
/// Duration of the fault, so far if it lasts [s].
[[nodiscard]] double fault_duration(const msg::Fault& fault);

[[nodiscard]] std::string arms_text(const msg::CellStatus& status, const Palette& palette, const Tools& tools = {});
/// "40 mm, holds crate"
[[nodiscard]] std::string gripper_text(const msg::ToolState& tool);
[[nodiscard]] std::string nodes_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string hosts_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string faults_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string obstacles_text(const msg::CellStatus& status, const Palette& palette);
/// "30 %", at most two decimals
[[nodiscard]] std::string speed_text(double speed);
/// "cell three_puma: run, speed 30 %, held arm2"
[[nodiscard]] std::string mode_text(const msg::CellStatus& status, const Palette& palette);
/// Everything but hosts and obstacles.
[[nodiscard]] std::string status_text(const msg::CellStatus& status, const Palette& palette, const Tools& tools = {});

[[nodiscard]] Json to_json(const msg::GoalStatus& goal);
/// Null for CAUSE_NONE.
[[nodiscard]] Json to_json(const msg::Cause& cause);
[[nodiscard]] Json to_json(const msg::ArmStatus& arm);
[[nodiscard]] Json to_json(const msg::NodeStatus& node);
[[nodiscard]] Json to_json(const msg::HostStatus& host);
[[nodiscard]] Json to_json(const msg::Fault& fault);
[[nodiscard]] Json to_json(const msg::ObstacleStatus& obstacle);
[[nodiscard]] Json to_json(const msg::Separation& separation);
[[nodiscard]] Json to_json(const msg::ContactReport& report);
[[nodiscard]] Json to_json(const msg::LostArm& lost);
[[nodiscard]] Json to_json(const msg::CellMode& mode);
[[nodiscard]] Json to_json(const msg::CellStatus& status);
/// As `hecaton tool` shows it.
[[nodiscard]] Json to_json(const msg::ToolState& tool);
/// Adds the key "tool" to each arm in the JSON of a list of arms; null: no gripper.
void add_tools(Json& arms, const Tools& tools);

template <class T>
[[nodiscard]] Json list_json(const std::vector<T>& items) {
  Json list = Json::array();
  for (const T& item : items) list.push_back(to_json(item));
  return list;
}

}  // namespace hecaton::services::cli
