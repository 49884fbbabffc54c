#pragma once
/// The names of the planning methods on the command line.

#include <string>

#include "planner/local/parameters.hpp"

namespace CLI {
class App;
}  // namespace CLI

namespace hecaton::services::cli {

/// --method, one of the names that method_of knows; empty: as the cell file says.
void add_method(CLI::App& app, std::string& name);

/// "local", "single_subspace", "boundary_following"
[[nodiscard]] planner::Method method_of(const std::string& name);

/// The reverse.
[[nodiscard]] std::string method_name(planner::Method method);

}  // namespace hecaton::services::cli
