#pragma once
/// How commands reach a running cell by the client library, and the exit codes of its errors.

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <hecaton/client.hpp>
#include <idl/supervisor.h>

#include "services/client/connection.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {

using Connection = std::shared_ptr<client::Connection>;

/// "north, west and east"; "none" without names.
[[nodiscard]] std::string listed(const std::vector<std::string>& names);

/// Time limit of each request of a command.
[[nodiscard]] Wait answer_limit(const Settings& settings);
/// Connects to the cell that the settings name. Throws as hecaton::Cell::connect does.
[[nodiscard]] Connection connect(const Settings& settings);

/// An error of the client library with its exit code.
[[nodiscard]] Failure failure_of(const Error& error);
/// `action`, which throws Failure in place of errors of the client library.
[[nodiscard]] std::function<ExitCode()> on_cell(std::function<ExitCode()> action);

/// Throws Failure (bad input) with the names of the cell's arms when it has no such arm.
const msg::ArmStatus& require_arm(const msg::CellStatus& status, std::string_view arm);
void require_arms(const msg::CellStatus& status, const std::vector<std::string>& arms);

/// Whether an order for `arms`, empty: for all of the cell, concerns this one.
[[nodiscard]] bool concerns(const std::vector<std::string>& arms, const msg::ArmStatus& arm);

}  // namespace hecaton::services::cli
