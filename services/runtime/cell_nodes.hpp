#pragma once
/// Where a cell file places planners and supervisors. A node with a standby host runs twice: one instance is in charge,
/// the other stands by. The roles change while the cell runs, so names only tell the host: "planner/arm1", and
/// "planner/arm1@beta" on the standby host beta.

#include <algorithm>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {

struct PlacedNode {
  std::string node;
  std::string host;
};

/// The node on its host and, unless `standby_host` is empty, its standby. The first is in charge when the cell starts.
[[nodiscard]] inline std::vector<PlacedNode> placed_nodes(const std::string& node, const std::string& host,
                                                          const std::string& standby_host) {
  std::vector<PlacedNode> nodes{{node, host}};
  if (!standby_host.empty()) nodes.push_back({standby_node(node, standby_host), standby_host});
  return nodes;
}

/// `arm`: index in the cell.
[[nodiscard]] inline std::vector<PlacedNode> planners_of(const config::CellFile& file, std::size_t arm) {
  const config::ArmHosts& hosts = file.arm_hosts[arm];
  return placed_nodes(planner_node(file.cell.arms[arm].arm.name), hosts.host, hosts.standby_host);
}
[[nodiscard]] inline std::vector<PlacedNode> supervisors_of(const config::CellFile& file) {
  return placed_nodes(supervisor_node(), file.supervision.host, file.supervision.standby_host);
}

/// Index of the node on `host`; 0 when no node is placed there (the host's own name then differs from the cell file's).
[[nodiscard]] inline std::size_t index_on(const std::vector<PlacedNode>& nodes, const std::string& host) {
  const auto found =
      std::find_if(nodes.begin(), nodes.end(), [&](const PlacedNode& node) { return node.host == host; });
  return found == nodes.end() ? 0 : static_cast<std::size_t>(found - nodes.begin());
}

}  // namespace hecaton::services
