#include <CLI/CLI.hpp>

#include "services/strategies/commands.hpp"

namespace hecaton::services::cli {

const Program& strategies_program() {
  static const Program program{
      "hecaton-strategies", "off-line search of motion strategies for robot arms that share a workspace",
      "Searches, shows and validates motion strategies: the plane of joint space in which each arm avoids the other "
      "arms.",
      "For each arm, a strategy has coefficients α, β, …, which define the plane of joint space in which the arm "
      "avoids "
      "others, and a first direction λ = 1 or -1. A fault is a task that takes 200 times as long as it would take "
      "alone. T is the mean time of a task, summed over the arms [steps]. See docs/explanation/strategies.md.\n\n"
      "  hecaton-strategies search CELL --results found             search a grid\n"
      "  hecaton-strategies validate CELL --strategies found.csv    evaluate the best on new tasks\n"
      "  strategy: {file: found.yaml}                               use it, in the cell file\n\n"
      "Exit codes: 0 done; 1 a strategy had a fault; 2 usage: unknown command, option or choice; 3 bad input: an "
      "invalid value on the command line or in a file; 130 interrupted by Ctrl-C (SIGINT) or 143 by SIGTERM: the "
      "output "
      "has what was done so far; a second signal ends at once.",
      [](CLI::App& app, Session& session) {
        add_search(app, session);
        add_show(app, session);
        add_validate(app, session);
        add_simplex(app, session);
        add_plot(app, session);
      }};
  return program;
}

}  // namespace hecaton::services::cli
