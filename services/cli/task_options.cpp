#include "services/cli/task_options.hpp"

#include <limits>

#include <CLI/CLI.hpp>

#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"

namespace hecaton::services::cli {

CLI::Option* add_seed(CLI::App& app, std::uint64_t& seed, const std::string& description) {
  return add_whole_number(
             app, "--seed", [&seed](std::uint64_t value) { seed = value; }, description, 0,
             std::numeric_limits<std::uint64_t>::max())
      ->type_name("S");
}

void require_tasks(const config::CellFile& file) {
  const planner::TaskArea& tasks = file.cell.tasks;
  if (!tasks.route.empty() || !tasks.problem.areas.empty() || tasks.radius > 0.0) return;
  throw Failure(ExitCode::kBadInput,
                file.path +
                    ": tasks is missing, but random goals (--tasks) need it: a map with centre and "
                    "radius of the area that the arms share, or with a route of named poses");
}

}  // namespace hecaton::services::cli
