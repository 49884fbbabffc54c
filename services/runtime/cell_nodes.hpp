#pragma once
/// The nodes that share one duty of a cell: one is in charge, the other stands by on another host. Which is which
/// changes while the cell runs, so names only tell where: "planner/arm1", and "planner/arm1@beta" on the standby's
/// host.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"

namespace hecaton::services {

struct PlacedNode {
  std::string node;
  std::string host;
};

/// `arm`: index in the cell. The first is to be in charge when the cell comes up.
[[nodiscard]] std::vector<PlacedNode> planners_of(const config::CellFile& file, std::size_t arm);
[[nodiscard]] std::vector<PlacedNode> supervisors_of(const config::CellFile& file);

/// Index of the node that runs on `host`; the first when none does (its own host then is another name for it).
[[nodiscard]] std::size_t index_on(const std::vector<PlacedNode>& nodes, const std::string& host);

}  // namespace hecaton::services
