#pragma once
/// What the identities of a secured cell are for, by its cell file.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/security/permissions.hpp"

namespace hecaton::services {

struct HostDuties {
  std::string host;
  std::vector<Duty> duties;  ///< each role at most once, in the order of kRoles
};

/// What the agent and the services of each host do, in the order of the file, and at the end what persons do: give
/// orders, and watch. Planners and drivers have the arms that the file places there.
[[nodiscard]] std::vector<HostDuties> duties_of(const config::CellFile& file);

}  // namespace hecaton::services
