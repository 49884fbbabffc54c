#pragma once
/// The whole command line of `hecaton`.

#include "services/command_line/program.hpp"

namespace hecaton::services::cli {

[[nodiscard]] const Program& hecaton_program();

}  // namespace hecaton::services::cli
