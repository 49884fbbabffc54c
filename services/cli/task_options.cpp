#include "services/cli/task_options.hpp"

#include "services/command_line/failure.hpp"
#include "services/command_line/quantities.hpp"

namespace hecaton::services::cli {

void require_tasks(const config::CellFile& file) {
  const planner::TaskArea& tasks = file.cell.tasks;
  if (!tasks.route.empty() || !tasks.problem.areas.empty() || tasks.radius > 0.0) return;
  throw Failure(ExitCode::kBadInput,
                file.path +
                    ": tasks is missing, but random goals (--tasks) need it: a map with centre and "
                    "radius of the area that the arms share, or with a route of named poses");
}

}  // namespace hecaton::services::cli
