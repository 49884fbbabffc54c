#pragma once
/// What `up` and `simulate` have in common: random tasks.

#include <cstdint>
#include <string>

#include "services/command_line/quantities.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services::cli {

inline constexpr std::uint64_t kMostTasks = 100'000'000;

/// Throws Failure (bad input) when the cell file does not say where tasks are.
void require_tasks(const config::CellFile& file);

}  // namespace hecaton::services::cli
