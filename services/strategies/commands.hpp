#pragma once
/// The commands of `hecaton-strategies`. Each function adds a subcommand, which sets `session.action` when the user
/// gives it. All references must outlive the action.

#include "services/command_line/program.hpp"

namespace hecaton::services::cli {

void add_search(CLI::App& app, Session& session);
void add_show(CLI::App& app, Session& session);
void add_validate(CLI::App& app, Session& session);
void add_simplex(CLI::App& app, Session& session);
void add_plot(CLI::App& app, Session& session);

[[nodiscard]] const Program& strategies_program();

}  // namespace hecaton::services::cli
