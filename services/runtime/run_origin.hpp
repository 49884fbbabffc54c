#pragma once
/// What the memory of a run is of.

#include <string>

#include "planner/model/source_file.hpp"

namespace hecaton::services {

/// Text that is the same for two runs only when what one remembers is true for the other: poses and obstacles are of
/// the robots and the world that the cell's files describe (their names and all of their bytes), the files' format is
/// that of the program's version, and times are of this machine's clock, which begins anew when it does. Of the files
/// in `sources.read()`. Throws std::runtime_error with a sentence when one of them is
/// gone.
[[nodiscard]] std::string run_origin(const planner::SourceFiles& sources);

}  // namespace hecaton::services
