/// hecaton hold, resume, stop: whether the cell or some arms may move.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_json.hpp"
#include "services/cli/status_text.hpp"
#include "services/command_line/failure.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services::cli {
namespace {

/// Resuming the cell leaves alone who was stopped by name.
void tell_stopped(const msg::CellMode& mode) {
  std::string names;
  for (const std::string& arm : arms_on(mode, msg::Mode::MODE_STOP)) names += " " + arm;
  if (names.empty()) return;
  std::fprintf(stderr, "still stopped by name:%s; 'hecaton resume%s' lets them move again\n", names.c_str(),
               names.c_str());
}

/// Without an answer an order counts as not obeyed.
msg::SupervisorReply order(const Settings& settings, msg::RequestKind kind, const std::vector<std::string>& arms) {
  try {
    const Connection cell = connect(settings);
    require_arms(cell->status(answer_limit(settings)), arms);
    return cell->order(kind, arms, answer_limit(settings));
  } catch (const Unreachable& unreachable) {
    throw Failure(ExitCode::kUnreachable, "nobody has obeyed, and what moves goes on: looked for " +
                                              unreachable.reason().looked_for + ", but " +
                                              failure_of(unreachable).what());
  }
}

ExitCode run(const Settings& settings, msg::RequestKind kind, const std::vector<std::string>& arms) {
  const msg::SupervisorReply reply = order(settings, kind, arms);
  if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  if (!is_none(reply.cause())) std::fprintf(stderr, "done, but %s\n", reply.cause().text().c_str());
  if (kind == msg::RequestKind::REQUEST_RESUME && arms.empty()) tell_stopped(reply.status().mode());
  print(settings, to_json(reply.status().mode()), mode_text(reply.status(), Palette::for_stream(stdout)));
  return ExitCode::kDone;
}

void add_mode(CLI::App& app, Session& session, const char* name, const char* description, msg::RequestKind kind) {
  CLI::App* command = app.add_subcommand(name, description);
  auto arms = std::make_shared<std::vector<std::string>>();
  command->add_option("ARM", *arms, "names of arms; none: the whole cell");
  command->callback([&session, arms, kind] {
    session.action = on_cell([&session, arms, kind] { return run(session.settings, kind, *arms); });
  });
}

}  // namespace

void add_mode_commands(CLI::App& app, Session& session) {
  add_mode(app, session, "hold", "Brakes the cell or some arms; goals are kept until resume",
           msg::RequestKind::REQUEST_HOLD);
  add_mode(app, session, "resume", "Lets the cell or some arms move again; arms that were stopped by name only by name",
           msg::RequestKind::REQUEST_RESUME);
  add_mode(app, session, "stop", "Brakes the cell or some arms and latches it until resume",
           msg::RequestKind::REQUEST_STOP);
}

}  // namespace hecaton::services::cli
