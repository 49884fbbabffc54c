#include "services/agent/service_plan.hpp"

#include <algorithm>
#include <stdexcept>

#include "services/config/text.hpp"
#include "services/runtime/cell_nodes.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services {
namespace {

constexpr const char* kSupervisor = "hecaton-supervisor";
constexpr const char* kWorld = "hecaton-world";
constexpr const char* kRos2 = "hecaton-ros2";
constexpr const char* kPlanner = "hecaton-planner";
constexpr const char* kView = "hecaton-view";
constexpr const char* kRecorder = "hecaton-recorder";

/// "planner/arm1" → "planner-arm1"
std::string process_name(std::string node) {
  std::replace(node.begin(), node.end(), '/', '-');
  return node;
}

}  // namespace

void require_host(const config::CellFile& file, const std::string& host) {
  std::string names;
  for (const config::Host& known : file.hosts) {
    if (known.name == host) return;
    names += (names.empty() ? "" : ", ") + known.name;
  }
  throw std::runtime_error(file.path + ": --host '" + config::printable(host) + "' must be one of " + names);
}

std::vector<std::string> planned_hosts(const config::CellFile& file, const std::string& host) {
  if (!host.empty()) {
    require_host(file, host);
    return {host};
  }
  std::vector<std::string> hosts;
  for (const config::Host& known : file.hosts) hosts.push_back(known.name);
  return hosts;
}

std::vector<PlannedService> plan_services(const config::CellFile& file, const std::string& host) {
  std::vector<PlannedService> services;
  services.push_back({"world", world_node(), file.world_host, kWorld, {file.path}});
  for (const PlacedNode& supervisor : supervisors_of(file)) {
    services.push_back({process_name(supervisor.node), supervisor.node, supervisor.host, kSupervisor, {file.path}});
  }
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string& arm = file.cell.arms[i].arm.name;
    const std::vector<std::string> arguments{file.path, "--arm", arm};
    const std::string driver = driver_node(arm);
    services.push_back({process_name(driver), driver, file.arm_hosts[i].host, "hecaton-arm-driver", arguments});
    for (const PlacedNode& planner : planners_of(file, i)) {
      services.push_back({process_name(planner.node), planner.node, planner.host, kPlanner, arguments});
    }
  }
  if (file.view) services.push_back({view_node(), view_node(), file.view->host, kView, {file.path}});
  if (file.record) {
    services.push_back({recorder_node(), recorder_node(), file.record->host, kRecorder, {file.path}});
  }
  if (file.ros2) services.push_back({"ros2", ros2_node(), file.ros2->host, kRos2, {file.path}});
  const auto hosts = planned_hosts(file, host);
  std::erase_if(services, [&](const PlannedService& service) {
    return std::find(hosts.begin(), hosts.end(), service.host) == hosts.end();
  });
  for (PlannedService& service : services) {
    service.arguments.insert(service.arguments.end(), {"--host", service.host});
  }
  return services;
}

}  // namespace hecaton::services
