#include "services/runtime/cell_nodes.hpp"

#include <algorithm>

#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

std::vector<PlacedNode> placed(const std::string& node, const std::string& host, const std::string& standby_host) {
  std::vector<PlacedNode> nodes{{node, host}};
  if (!standby_host.empty()) nodes.push_back({standby_node(node, standby_host), standby_host});
  return nodes;
}

}  // namespace

std::vector<PlacedNode> planners_of(const config::CellFile& file, std::size_t arm) {
  const config::ArmHosts& hosts = file.arm_hosts[arm];
  return placed(planner_node(file.cell.arms[arm].arm.name), hosts.host, hosts.standby_host);
}

std::vector<PlacedNode> supervisors_of(const config::CellFile& file) {
  return placed(supervisor_node(), file.supervision.host, file.supervision.standby_host);
}

std::size_t index_on(const std::vector<PlacedNode>& nodes, const std::string& host) {
  const auto found =
      std::find_if(nodes.begin(), nodes.end(), [&](const PlacedNode& node) { return node.host == host; });
  return found == nodes.end() ? 0 : static_cast<std::size_t>(found - nodes.begin());
}

}  // namespace hecaton::services
