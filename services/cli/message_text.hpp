#pragma once
/// Short texts for people about messages.

#include <string>

#include <idl/supervisor.h>

#include "services/command_line/terminal.hpp"
#include "services/messages/names.hpp"

namespace hecaton::services::cli {

/// "arm2/forearm – pallet, 18 mm"; empty without binding.
[[nodiscard]] std::string binding_text(const msg::GoalStatus& goal);
/// Why the goal is where it is: reason, what binds, and while it is open what is tried; empty when there is nothing to
/// tell.
[[nodiscard]] std::string why_text(const msg::GoalStatus& goal);
/// "blocked: no way around pallet (arm2/forearm – pallet, 18 mm); draws another subspace"
[[nodiscard]] std::string goal_text(const msg::GoalStatus& goal);
/// What the arm waits for, or else what binds its motion.
[[nodiscard]] std::string waiting_text(const msg::ArmStatus& arm);
/// "0 contacts, smallest separation 31 mm (arm1/wrist – arm2/forearm)"
[[nodiscard]] std::string referee_text(const msg::RefereeReport& report, const Palette& palette);
/// How long it lasted, or has lasted so far [s].
[[nodiscard]] double fault_duration(const msg::Fault& fault);
/// "14:03:59" of the wall clock, local time.
[[nodiscard]] std::string clock_text(long long unix_ms);

}  // namespace hecaton::services::cli
