#pragma once
/// Every command of `hecaton`, each in its own file: adds itself to the command line, and leaves what it does in
/// `session.action` when it was given. All references must outlive the action.

#include "services/command_line/settings.hpp"

namespace hecaton::services::cli {

void add_up(CLI::App& app, Session& session);
void add_agent(CLI::App& app, Session& session);
void add_status(CLI::App& app, Session& session);
void add_arms(CLI::App& app, Session& session);
void add_faults(CLI::App& app, Session& session);
void add_obstacles(CLI::App& app, Session& session);
void add_hosts(CLI::App& app, Session& session);
void add_goal(CLI::App& app, Session& session);
void add_wait(CLI::App& app, Session& session);
void add_mode_commands(CLI::App& app, Session& session);  ///< hold, resume, stop
void add_obstacle(CLI::App& app, Session& session);
void add_carry_commands(CLI::App& app, Session& session);  ///< attach, detach
void add_check(CLI::App& app, Session& session);
void add_plan(CLI::App& app, Session& session);
void add_simulate(CLI::App& app, Session& session);

}  // namespace hecaton::services::cli
