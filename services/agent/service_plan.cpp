#include "services/agent/service_plan.hpp"

#include <algorithm>
#include <stdexcept>

#include "services/runtime/node_name.hpp"

namespace hecaton::services {

std::vector<std::string> planned_hosts(const config::CellFile& file, const std::string& host) {
  std::vector<std::string> hosts;
  std::string names;
  for (const config::Host& candidate : file.hosts) {
    names += (names.empty() ? "" : ", ") + candidate.name;
    if (host.empty() || candidate.name == host) hosts.push_back(candidate.name);
  }
  if (hosts.empty()) throw std::runtime_error(file.path + ": --host " + host + " must be one of " + names);
  return hosts;
}

std::vector<PlannedService> plan_services(const config::CellFile& file, const std::string& host) {
  std::vector<PlannedService> services;
  services.push_back({"world", world_node(), file.world_host, "hecaton-world", {file.path}});
  services.push_back({"supervisor", supervisor_node(), file.supervision.host, "hecaton-supervisor", {file.path}});
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string& arm = file.cell.arms[i].arm.name;
    const std::string& arm_host = file.arm_hosts[i].host;
    const std::vector<std::string> arguments{file.path, "--arm", arm};
    services.push_back({"driver-" + arm, driver_node(arm), arm_host, "hecaton-arm-driver", arguments});
    services.push_back({"planner-" + arm, planner_node(arm), arm_host, "hecaton-planner", arguments});
  }
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
