#include <CLI/CLI.hpp>

#include "services/cli/commands.hpp"
#include "services/command_line/options.hpp"
#include "services/runtime/options.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kExitCodes =
    "Exit codes: 0 done; 1 negative outcome (goal blocked or rejected, contacts, tasks missed); 2 usage: unknown, "
    "missing or surplus command, option or choice; 3 bad input: an invalid value on the command line, in a file or in "
    "the environment (number, name, cell, URDF, arm, object); 4 time-out; 5 no such cell reachable; 130 "
    "interrupted by Ctrl-C (SIGINT) or 143 by SIGTERM: reports have what was done so far; a second signal ends at "
    "once.";

void add_network_options(CLI::App& app, Settings& settings) {
  add_whole_number(
      app, "--domain", [&settings](std::uint64_t domain) { settings.domain = static_cast<int>(domain); },
      "DDS domain, 0 to 199 (HECATON_DOMAIN, the cell file's, or 42)", 0, kHighestDomain);
  app.add_option("--cell", settings.cell_file, "cell file with the network settings of the cell")
      ->envname("HECATON_CELL")
      ->type_name("FILE");
  add_duration(app, "--connect-timeout", settings.connect_timeout, "time limit for the answer of a running cell (2s)",
               0.01, 600.0);
}

void add_commands(CLI::App& app, Session& session) {
  add_network_options(app, session.settings);
  add_up(app, session);
  add_agent(app, session);
  add_status_commands(app, session);
  add_view(app, session);
  add_record(app, session);
  add_bag(app, session);
  add_replay(app, session);
  add_render(app, session);
  add_explain(app, session);
  add_goal(app, session);
  add_wait(app, session);
  add_mode_commands(app, session);
  add_speed(app, session);
  add_device(app, session);
  add_device_test(app, session);
  add_tool(app, session);
  add_io(app, session);
  add_posture(app, session);
  add_obstacle(app, session);
  add_carry_commands(app, session);
  add_init(app, session);
  add_robots(app, session);
  add_keystore(app, session);
  add_firewall(app, session);
  add_check(app, session);
  add_plan(app, session);
  add_simulate(app, session);
}

}  // namespace

const Program& hecaton_program() {
  static const Program program{
      "hecaton", "cells of robot arms that plan their motions together",
      "Drives cells of robot arms that plan their motions together: one planner process for each arm, on DDS.",
      kExitCodes, add_commands};
  return program;
}

}  // namespace hecaton::services::cli
