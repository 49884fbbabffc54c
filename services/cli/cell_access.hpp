#pragma once
/// How commands reach a running cell: the client library, and what its answers mean for exit codes.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <hecaton/client.hpp>
#include <idl/supervisor.h>

#include "services/client/connection.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/settings.hpp"

namespace hecaton::services::cli {

using Connection = std::shared_ptr<client::Connection>;

/// "north, west and east"; "none" without names.
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

[[nodiscard]] ConnectOptions place_of(const Settings& settings);
/// How long each question, order or edit of a command may take.
[[nodiscard]] Wait answer_limit(const Settings& settings);
/// A connection to the cell that the settings name. Throws what hecaton::Cell::connect throws.
[[nodiscard]] Connection connect(const Settings& settings);

/// What an error of the client library is for the command line.
[[nodiscard]] Failure failure_of(const Error& error);
/// The same action, whose errors of the client library are Failures.
[[nodiscard]] std::function<ExitCode()> on_cell(std::function<ExitCode()> action);

/// Throws Failure (bad input) that names the known ones when the cell has no such arm.
const msg::ArmStatus& require_arm(const msg::CellStatus& status, std::string_view arm);
void require_arms(const msg::CellStatus& status, const std::vector<std::string>& arms);

/// What `status` means for a command that waits for the goal to be reached.
[[nodiscard]] ExitCode outcome_code(const msg::GoalStatus& status);

}  // namespace hecaton::services::cli
