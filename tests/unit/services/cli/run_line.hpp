#pragma once
/// Runs a command line of `hecaton` inside the test process.

#include <utility>

#include "services/cli/commands.hpp"
#include "tests/unit/services/command_line/run_program_line.hpp"

namespace hecaton::services::cli {

inline Ran run_line(std::vector<std::string> words) {
  return run_line(hecaton_program(), std::move(words));
}

}  // namespace hecaton::services::cli
