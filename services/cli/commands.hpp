#pragma once
/// The program `hecaton` and its commands, each in its own file.

#include <iosfwd>
#include <string>
#include <vector>

#include "services/cli/robot_options.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {

/// The whole command line.
[[nodiscard]] const Program& hecaton_program();

// Each function adds a command to `app`. When the command is given, its callback sets `session.action`. `session` must
// outlive the action.
void add_up(CLI::App& app, Session& session);
void add_agent(CLI::App& app, Session& session);
void add_status_commands(CLI::App& app, Session& session);  ///< status, arms, faults, obstacles, hosts
void add_goal(CLI::App& app, Session& session);
void add_wait(CLI::App& app, Session& session);
void add_mode_commands(CLI::App& app, Session& session);  ///< hold, resume, stop
void add_speed(CLI::App& app, Session& session);
void add_device(CLI::App& app, Session& session);
void add_device_test(CLI::App& app, Session& session);
void add_tool(CLI::App& app, Session& session);
void add_io(CLI::App& app, Session& session);
void add_posture(CLI::App& app, Session& session);
void add_obstacle(CLI::App& app, Session& session);
void add_carry_commands(CLI::App& app, Session& session);  ///< attach, detach
void add_check(CLI::App& app, Session& session);
void add_init(CLI::App& app, Session& session);
void add_robots(CLI::App& app, Session& session);
void add_plan(CLI::App& app, Session& session);
void add_simulate(CLI::App& app, Session& session);
void add_view(CLI::App& app, Session& session);
void add_record(CLI::App& app, Session& session);
void add_keystore(CLI::App& app, Session& session);
void add_firewall(CLI::App& app, Session& session);
void add_bag(CLI::App& app, Session& session);  ///< bag info, bag export
void add_replay(CLI::App& app, Session& session);
void add_explain(CLI::App& app, Session& session);
void add_render(CLI::App& app, Session& session);

/// Asks for the arms of `hecaton init` until an empty name ends the list; answers that are no arm are explained and
/// asked again. Returns words for parse_draft_arm(), at least one. Throws Failure (usage) when the input ends earlier.
[[nodiscard]] std::vector<std::string> ask_for_arms(std::istream& in, std::ostream& out,
                                                    const RobotFileOptions& files = {});

}  // namespace hecaton::services::cli
