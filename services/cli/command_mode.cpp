/// hecaton hold, resume, stop: allow or forbid motion of the cell or of some arms.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/program.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services::cli {
namespace {

/// Resuming the cell does not resume arms that were stopped by name.
void print_stopped(const msg::CellMode& mode) {
  std::string names;
  for (const std::string& arm : arms_on(mode, msg::Mode::MODE_STOP)) names += " " + arm;
  if (names.empty()) return;
  std::fprintf(stderr, "arms stopped by name stay stopped:%s; resume them with 'hecaton resume%s'\n", names.c_str(),
               names.c_str());
}

/// An order without a reply fails: it may not have been obeyed.
msg::SupervisorReply order(const Settings& settings, msg::RequestKind kind, const std::vector<std::string>& arms) {
  try {
    const Connection cell = connect(settings);
    require_arms(cell->status(answer_limit(settings)), arms);
    return cell->order(kind, arms, answer_limit(settings));
  } catch (const Unreachable& unreachable) {
    throw Failure(ExitCode::kUnreachable, "the order was not obeyed, and arms may still move: looked for " +
                                              unreachable.reason().looked_for + ", but " +
                                              failure_of(unreachable).what());
  }
}

ExitCode run(const Settings& settings, msg::RequestKind kind, const std::vector<std::string>& arms) {
  const msg::SupervisorReply reply = order(settings, kind, arms);
  if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  if (!is_none(reply.cause())) std::fprintf(stderr, "done, but %s\n", reply.cause().text().c_str());
  if (kind == msg::RequestKind::REQUEST_RESUME && arms.empty()) print_stopped(reply.status().mode());
  print(settings, to_json(reply.status().mode()), mode_text(reply.status(), Palette::for_stream(stdout)));
  return ExitCode::kDone;
}

void add_mode(CLI::App& app, Session& session, const char* name, const char* description, msg::RequestKind kind) {
  CLI::App* command = app.add_subcommand(name, description);
  auto arms = std::make_shared<std::vector<std::string>>();
  command->add_option("ARM", *arms, "names of arms (the whole cell)");
  command->callback([&session, arms, kind] {
    session.action = on_cell([&session, arms, kind] { return run(session.settings, kind, *arms); });
  });
}

}  // namespace

void add_mode_commands(CLI::App& app, Session& session) {
  add_mode(app, session, "hold", "Brakes the cell or some arms; goals are kept until resume",
           msg::RequestKind::REQUEST_HOLD);
  add_mode(app, session, "resume",
           "Lets the cell or some arms move again; arms that were stopped by name must be named",
           msg::RequestKind::REQUEST_RESUME);
  add_mode(app, session, "stop", "Brakes the cell or some arms and latches it until resume",
           msg::RequestKind::REQUEST_STOP);
}

}  // namespace hecaton::services::cli
