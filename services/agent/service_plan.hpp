#pragma once
/// The services that a cell file places on a host, and how each is started.

#include <string>
#include <vector>

#include "services/config/cell_file.hpp"

namespace hecaton::services {

struct PlannedService {
  std::string name;                    ///< "planner-arm1", "planner-arm1@host2": also the name of its log
  std::string node;                    ///< as in its heartbeat
  std::string host;                    ///< of the cell file
  std::string program;                 ///< file name of its executable
  std::vector<std::string> arguments;  ///< without the program's own name
};

/// In the order of their start: world, supervisors, then the driver and the planners of each arm, the view, the
/// recorder and the ROS 2 service. `host`: of the cell file; empty: all hosts. Throws std::runtime_error with a
/// sentence when the cell has no such host.
[[nodiscard]] std::vector<PlannedService> plan_services(const config::CellFile& file, const std::string& host);

/// Throws std::runtime_error with a sentence that names the cell's hosts when `host` (of --host) is none of them.
void require_host(const config::CellFile& file, const std::string& host);

/// The hosts whose services plan_services() returns for the same `host`.
[[nodiscard]] std::vector<std::string> planned_hosts(const config::CellFile& file, const std::string& host);

}  // namespace hecaton::services
