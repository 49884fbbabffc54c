#include "services/runtime/cell_duties.hpp"

#include <algorithm>

#include "services/runtime/cell_nodes.hpp"
#include "services/security/keystore.hpp"

namespace hecaton::services {
namespace {

void add(std::vector<HostDuties>& all, const std::string& host, Role role, const std::string& arm = {}) {
  auto at = std::find_if(all.begin(), all.end(), [&](const HostDuties& one) { return one.host == host; });
  if (at == all.end()) at = all.insert(all.end(), HostDuties{host, {}});
  auto duty = std::find_if(at->duties.begin(), at->duties.end(), [&](const Duty& one) { return one.role == role; });
  if (duty == at->duties.end()) duty = at->duties.insert(at->duties.end(), Duty{role, {}});
  if (!arm.empty()) duty->arms.push_back(arm);
}

}  // namespace

std::vector<HostDuties> duties_of(const config::CellFile& file) {
  std::vector<HostDuties> all;
  for (const config::Host& host : file.hosts) add(all, host.name, Role::kAgent);
  for (const PlacedNode& supervisor : supervisors_of(file)) add(all, supervisor.host, Role::kSupervisor);
  add(all, file.world_host, Role::kWorld);
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string& arm = file.cell.arms[i].arm.name;
    add(all, file.arm_hosts[i].host, Role::kDriver, arm);
    for (const PlacedNode& planner : planners_of(file, i)) add(all, planner.host, Role::kPlanner, arm);
  }
  if (file.view) {
    add(all, file.view->host, Role::kViewer);
    if (file.view->control || !file.view->no_stop) add(all, file.view->host, Role::kOperator);
  }
  if (file.record) add(all, file.record->host, Role::kViewer);
  if (file.ros2) {
    add(all, file.ros2->host, Role::kViewer);
    add(all, file.ros2->host, Role::kOperator);
  }
  for (const Role role : {Role::kOperator, Role::kViewer}) add(all, kPeople, role);
  for (HostDuties& one : all) {
    std::sort(one.duties.begin(), one.duties.end(), [](const Duty& a, const Duty& b) { return a.role < b.role; });
  }
  return all;
}

}  // namespace hecaton::services
