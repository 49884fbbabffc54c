/// hecaton status, arms, faults, obstacles, hosts: the state of a cell, its age, and why arms stand still.

#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/terminal.hpp"
#include "services/runtime/shutdown.hpp"

namespace hecaton::services::cli {
namespace {

/// The output of one command.
struct View {
  const char* name;
  const char* description;
  Json (*json)(const msg::CellStatus&, const Tools&);
  std::string (*text)(const msg::CellStatus&, const Palette&, const Tools&);
  bool has_tools = false;
};

/// A driver sends the state of its gripper as soon as it has found this process.
constexpr std::chrono::milliseconds kToolLimit{500};

/// The grippers that are heard within the limit. Only arms with joints outside the chain are waited for.
Tools tools_of(const Connection& cell, const View& view, const msg::CellStatus& status) {
  Tools tools;
  if (!view.has_tools) return tools;
  const auto until = client::Clock::now() + kToolLimit;
  for (const bool waits : {true, false}) {
    for (const msg::ArmStatus& arm : status.arms()) {
      if ((arm.driver_alive() && !arm.state().outside().empty()) != waits) continue;
      const Seconds limit = waits ? Seconds(until - client::Clock::now()) : Seconds::zero();
      const auto tool = cell->tool_state(arm.arm(), limit);
      if (tool && tool->value.has_gripper()) tools.emplace(arm.arm(), tool->value);
    }
  }
  return tools;
}

struct StatusOptions {
  bool watch = false;
  double interval = 0.5;  // [s]
};

std::string output(const Settings& settings, const View& view, const msg::CellStatus& status, const Tools& tools,
                   const Palette& palette) {
  switch (settings.format()) {
    case OutputFormat::kTable:
      return view.text(status, palette, tools);
    case OutputFormat::kJson:
      return view.json(status, tools).dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
    case OutputFormat::kYaml:
      return "---\n" + yaml_text(view.json(status, tools));
  }
  return {};
}

/// Prints until a signal comes or stdout cannot be written. JSON: one document a line; YAML: one document after
/// another.
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
    std::string text = output(settings, view, status, tools_of(cell, view, status), palette);
    if (!answers && settings.format() == OutputFormat::kTable) {
      text = palette.red("no answer for " + duration_text(Seconds(client::Clock::now() - answered).count()) +
                         "; last status:") +
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
  const Connection cell = connect(settings);
  const msg::CellStatus status = cell->status(answer_limit(settings));
  const Tools tools = tools_of(cell, view, status);
  print(settings, view.json(status, tools), view.text(status, Palette::for_stream(stdout), tools));
  return ExitCode::kDone;
}

void add_view(CLI::App& app, Session& session, const View& view) {
  CLI::App* command = app.add_subcommand(view.name, view.description);
  auto options = std::make_shared<StatusOptions>();
  command->add_flag("-w,--watch", options->watch, "repeat until Ctrl-C, on a terminal in place");
  add_duration(*command, "--interval", options->interval, "time between two requests (500ms)", 0.01, 3600.0);
  command->callback([&session, options, view] {
    session.action = on_cell([&session, options, view] {
      return options->watch ? watch(session.settings, view, options->interval) : show(session.settings, view);
    });
  });
}

}  // namespace

void add_status_commands(CLI::App& app, Session& session) {
  add_view(app, session,
           {"status", "Shows the cell: mode, arms and why they wait, nodes, faults, contacts",
            [](const msg::CellStatus& status, const Tools& tools) {
              Json json = to_json(status);
              add_tools(json["arms"], tools);
              return json;
            },
            status_text, true});
  add_view(app, session,
           {"arms", "Shows the arms: mode, goal, and why they stand still",
            [](const msg::CellStatus& status, const Tools& tools) {
              Json json = list_json(status.arms());
              add_tools(json, tools);
              return json;
            },
            arms_text, true});
  add_view(app, session,
           {"faults", "Shows the present faults and the last ones that were cleared",
            [](const msg::CellStatus& status, const Tools&) { return list_json(status.faults()); },
            [](const msg::CellStatus& status, const Palette& palette, const Tools&) {
              return faults_text(status, palette);
            }});
  add_view(app, session,
           {"obstacles", "Shows the obstacles, their positions and motions",
            [](const msg::CellStatus& status, const Tools&) { return list_json(status.obstacles()); },
            [](const msg::CellStatus& status, const Palette& palette, const Tools&) {
              return obstacles_text(status, palette);
            }});
  add_view(app, session,
           {"hosts", "Shows the hosts and the processes of their agents",
            [](const msg::CellStatus& status, const Tools&) { return list_json(status.hosts()); },
            [](const msg::CellStatus& status, const Palette& palette, const Tools&) {
              return hosts_text(status, palette);
            }});
}

}  // namespace hecaton::services::cli
