#pragma once
/// A cell file (YAML): the cell itself, and where on the network its services run. docs/reference/cell-file.md lists every key.

#include <chrono>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/methods/registry.hpp"
#include "planner/model/source_file.hpp"
#include "services/config/config_error.hpp"

namespace hecaton::config {

enum class Transport {
  kUdp,
  kSharedMemory,  ///< one host with one /dev/shm only
};

/// How processes find each other.
enum class Discovery {
  kMulticast,
  kUnicast,  ///< each announces itself to the hosts' addresses and to `peers`
};

struct Network {
  int domain = 42;  ///< DDS domain, 0 to 199
  Transport transport = Transport::kUdp;
  std::string interface;  ///< address or name of the network interface to use; empty: all
  Discovery discovery = Discovery::kMulticast;
  std::vector<std::string> peers;  ///< IPv4 addresses of other machines to announce to; kUnicast only
};

struct Host {
  std::string name;     ///< unique in the cell
  std::string address;  ///< IP address or DNS name
};

/// Where the services of one arm run. Names of declared hosts.
struct ArmHosts {
  std::string host;          ///< of the planner and the driver
  std::string standby_host;  ///< of the standby planner; empty: none
};

/// What moves an arm: `device:` of the cell file. Which types and keys there are, services/arm_driver/devices says.
struct DeviceOptions {
  std::string type = "simulated";
  std::map<std::string, std::string, std::less<>> values;  ///< its other keys
  std::string where;                                       ///< "FILE: arms[0].device", with which messages begin
};

/// Who watches, and after how long a silence is a fault.
struct Supervision {
  std::string host;
  std::string standby_host;  ///< of the standby supervisor; empty: none
  std::chrono::nanoseconds heartbeat_period = std::chrono::milliseconds(10);  ///< of every service's working loop
  /// No heartbeat for this long: the loop hangs. Whole milliseconds, as DDS deadlines are; > heartbeat_period.
  std::chrono::nanoseconds heartbeat_deadline = std::chrono::milliseconds(20);
  /// Liveliness lease: nothing for this long: host or link is lost; > heartbeat_deadline.
  std::chrono::nanoseconds host_lease = std::chrono::milliseconds(100);
  /// Liveliness lease between an active service and its standby; > heartbeat_period.
  std::chrono::nanoseconds failover_timeout = std::chrono::milliseconds(20);
  /// A process whose loop is silent for this long (before it begins: six times that) is killed and restarted; 0: never.
  std::chrono::nanoseconds watchdog = std::chrono::seconds(10);
  /// Kinds of faults, as in messages: what such a fault holds stays held until people resume it. Others' end by itself.
  std::set<std::string, std::less<>> waits_for_resume = {"contact"};
};

struct CellFile {
  std::string path;  ///< as given to load_cell_file
  planner::Cell cell;
  Network network;
  std::vector<Host> hosts;             ///< at least one, in the file's order
  std::vector<ArmHosts> arm_hosts;     ///< one per arm of the cell
  std::vector<DeviceOptions> devices;  ///< one per arm of the cell
  std::string world_host;
  Supervision supervision;
  planner::SourceFiles sources;  ///< which files it was read from
  bool real_time = false;        ///< services' loops have real-time priority where the machine allows it
};

/// Reads, and checks that the cell can start: see check_start. `snapshot`: the folder of copies to read instead (see
/// planner::SourceFiles). `methods`: what the key `method` may name. Throws ConfigError.
[[nodiscard]] CellFile load_cell_file(const std::string& path, const std::filesystem::path& snapshot = {},
                                      const planner::MethodRegistry& methods = planner::built_in_methods());

/// The same for a text, as if it stood in `path` (which names files relative to it, and messages).
[[nodiscard]] CellFile parse_cell_file(const std::string& text, const std::string& path,
                                       const planner::MethodRegistry& methods = planner::built_in_methods());

}  // namespace hecaton::config
