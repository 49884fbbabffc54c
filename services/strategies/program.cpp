#include <CLI/CLI.hpp>

#include "services/strategies/commands.hpp"

namespace hecaton::services::cli {

const Program& strategies_program() {
  static const Program program{
      "hecaton-strategies", "motion strategies of robot arms that share a workspace, found off line",
      "Searches, shows and validates motion strategies off line: in which plane each arm had best avoid the others.",
      "A strategy says, for each arm, in which plane of joint space it goes round what is in its way: coefficients α, "
      "β, …, and which way it turns first, λ = 1 or -1. A fault is a task that takes 200 times the time it would take "
      "alone; T is the mean time of a task, summed over the arms [steps]. docs/strategies.md says more.\n\n"
      "  hecaton-strategies search CELL --results found             the best of a grid\n"
      "  hecaton-strategies validate CELL --strategies found.csv    is the winner as good on fresh tasks?\n"
      "  strategy: {file: found.yaml}                               in the cell file, for arms to use it\n\n"
      "Exit codes: 0 done; 1 a strategy had a fault; 2 usage: no such command, option or choice; 3 bad input: a value "
      "that cannot be, on the command line or in a file.",
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
