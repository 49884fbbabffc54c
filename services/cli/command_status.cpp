/// hecaton status, arms, faults, obstacles, hosts: what is, how old that knowledge is, and why anything stands still.

#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_json.hpp"
#include "services/cli/status_text.hpp"
#include "services/command_line/quantities.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services::cli {
namespace {

/// One way to look at a cell.
struct View {
  const char* name;
  const char* description;
  Json (*json)(const msg::CellStatus&);
  std::string (*text)(const msg::CellStatus&, const Palette&);
};

struct Options {
  bool watch = false;
  double interval = 0.5;  // [s]
};

std::string formatted(const Settings& settings, const View& view, const msg::CellStatus& status,
                      const Palette& palette) {
  switch (settings.format()) {
    case OutputFormat::kTable:
      return view.text(status, palette);
    case OutputFormat::kJson:
      return view.json(status).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    case OutputFormat::kYaml:
      return "---\n" + yaml_text(view.json(status));
  }
  return {};
}

/// Until a signal comes or nobody reads any more. JSON: one document a line; YAML: one document after the other.
ExitCode watch(const Settings& settings, const View& view, double interval) {
  const Connection cell = connect(settings);
  ShutdownSignal shutdown;
  shutdown.wake(&cell->mailbox());
  msg::CellStatus status = cell->status(answer_limit(settings));
  Screen screen(stdout);
  const Palette palette = Palette::for_stream(stdout);
  auto due = client::Clock::now();
  auto answered = due;
  bool answers = true;
  while (!shutdown.requested()) {
    std::string text = formatted(settings, view, status, palette);
    if (!answers && settings.format() == OutputFormat::kTable) {
      text = palette.red("no answer for " + duration_text(Seconds(client::Clock::now() - answered).count()) +
                         "; last known:") +
             "\n" + text;
    }
    if ((answers || settings.format() == OutputFormat::kTable) && !screen.show(text)) break;
    const auto now = client::Clock::now();
    due = std::max(due + std::chrono::duration_cast<client::Clock::duration>(Seconds(interval)), now);
    if (cell->wait_until([&] { return shutdown.requested(); }, due - now)) break;
    const auto newest = cell->poll_status(Seconds(interval));
    answers = newest.has_value();
    if (answers) status = *newest;
    if (answers) answered = client::Clock::now();
  }
  return ExitCode::kDone;
}

ExitCode show(const Settings& settings, const View& view) {
  const msg::CellStatus status = connect(settings)->status(answer_limit(settings));
  print(settings, view.json(status), view.text(status, Palette::for_stream(stdout)));
  return ExitCode::kDone;
}

void add_view(CLI::App& app, Session& session, const View& view) {
  CLI::App* command = app.add_subcommand(view.name, view.description);
  auto options = std::make_shared<Options>();
  command->add_flag("-w,--watch", options->watch, "show it again and again, in place on a terminal, until Ctrl-C");
  add_duration(*command, "--interval", options->interval, "time between two looks (500ms)", 0.01, 3600.0);
  command->callback([&session, options, view] {
    session.action = on_cell([&session, options, view] {
      return options->watch ? watch(session.settings, view, options->interval) : show(session.settings, view);
    });
  });
}

}  // namespace

void add_status(CLI::App& app, Session& session) {
  add_view(app, session,
           {"status", "Shows the cell: mode, arms and what they wait for, nodes, faults, the referee's account",
            [](const msg::CellStatus& status) { return to_json(status); }, status_text});
}

void add_arms(CLI::App& app, Session& session) {
  add_view(app, session,
           {"arms", "Shows the arms: mode, goal, and why anything stands still",
            [](const msg::CellStatus& status) { return list_json(status.arms()); }, arms_text});
}

void add_faults(CLI::App& app, Session& session) {
  add_view(app, session,
           {"faults", "Shows the faults that last and the latest that are over",
            [](const msg::CellStatus& status) { return list_json(status.faults()); }, faults_text});
}

void add_obstacles(CLI::App& app, Session& session) {
  add_view(app, session,
           {"obstacles", "Shows the obstacles, where they are and how they move",
            [](const msg::CellStatus& status) { return list_json(status.obstacles()); }, obstacles_text});
}

void add_hosts(CLI::App& app, Session& session) {
  add_view(app, session,
           {"hosts", "Shows the hosts and the processes that their agents started",
            [](const msg::CellStatus& status) { return list_json(status.hosts()); }, hosts_text});
}

}  // namespace hecaton::services::cli
