#pragma once
/// The supervisor's picture of a cell for people.

#include <string>

#include <idl/supervisor.h>

#include "services/command_line/terminal.hpp"

namespace hecaton::services::cli {

[[nodiscard]] std::string arms_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string nodes_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string hosts_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string faults_text(const msg::CellStatus& status, const Palette& palette);
[[nodiscard]] std::string obstacles_text(const msg::CellStatus& status, const Palette& palette);
/// "cell three_puma: run; supervisor, up 12 s"
[[nodiscard]] std::string mode_text(const msg::CellStatus& status, const Palette& palette);
/// All of it but the obstacles.
[[nodiscard]] std::string status_text(const msg::CellStatus& status, const Palette& palette);

}  // namespace hecaton::services::cli
