#include "services/config/validate.hpp"

#include <algorithm>

#include "services/config/findings.hpp"

namespace hecaton::config {
namespace {

void note_standbys(const CellFile& file, Findings& findings) {
  if (file.hosts.size() < 2) return;
  for (int arm = 0; arm < static_cast<int>(file.arm_hosts.size()); ++arm) {
    if (!file.arm_hosts[arm].standby_host.empty()) continue;
    findings.push_back({Severity::kNote, arm_key(arm) + ".standby_host is missing: the arm stands still from the loss "
                                                        "of its planner's host until that is back"});
  }
  if (file.supervision.standby_host.empty()) {
    findings.push_back({Severity::kNote,
                        "supervision.standby_host is missing: nobody watches the cell from the loss of "
                        "the supervisor's host until that is back"});
  }
}

}  // namespace

std::string arm_key(int arm) {
  return "arms[" + std::to_string(arm) + "]";
}

std::vector<Finding> validate(const CellFile& file) {
  Findings findings;
  check_reach(file.cell, findings);
  check_clearances(file.cell, findings);
  check_dampers(file.cell, findings);
  check_obstacles(file.cell, findings);
  check_sensors(file.cell, findings);
  note_standbys(file, findings);
  std::stable_sort(findings.begin(), findings.end(),
                   [](const Finding& a, const Finding& b) { return a.severity > b.severity; });
  return findings;
}

}  // namespace hecaton::config
