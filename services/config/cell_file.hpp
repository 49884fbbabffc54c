#pragma once
/// A cell file (YAML): the cell, and the hosts of its services. docs/reference/cell-file.md lists every key.

#include <chrono>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/methods/registry.hpp"
#include "planner/model/source_file.hpp"
#include "services/config/shape_types.hpp"
#include "services/config/yaml_tree.hpp"

namespace hecaton::config {

enum class Transport {
  kUdp,
  kSharedMemory,  ///< one host with one /dev/shm only
};

/// How processes find each other.
enum class Discovery {
  kMulticast,
  kUnicast,  ///< each process announces itself to the hosts' addresses and to `peers`
};

/// `network`.
struct Network {
  int domain = 42;  ///< DDS domain, 0 to 199
  Transport transport = Transport::kUdp;
  std::string interface;  ///< address or name of the network interface to use; empty: all
  Discovery discovery = Discovery::kMulticast;
  std::vector<std::string> peers;  ///< IPv4 addresses of other machines to announce to; kUnicast only
};

/// A host of services.
struct Host {
  std::string name;     ///< unique in the cell
  std::string address;  ///< IP address or DNS name
};

/// The hosts of one arm's services, by name.
struct ArmHosts {
  std::string host;          ///< of the planner and the driver
  std::string standby_host;  ///< of the standby planner; empty: none
};

/// The device that moves an arm: `device` of the cell file. services/arm_driver/devices defines its types and keys.
struct DeviceOptions {
  std::string type = "simulated";
  std::map<std::string, std::string, std::less<>> values;  ///< its other keys
  std::string where;                                       ///< "FILE: arms[0].device", the beginning of messages
};

/// The supervisor's hosts, and the time limits of fault detection.
struct Supervision {
  std::string host;
  std::string standby_host;  ///< of the standby supervisor; empty: none
  std::chrono::nanoseconds heartbeat_period = std::chrono::milliseconds(10);  ///< of every service's working loop
  /// After this time without heartbeat a loop counts as hanging; > heartbeat_period, whole milliseconds for DDS.
  std::chrono::nanoseconds heartbeat_deadline = std::chrono::milliseconds(20);
  /// Liveliness lease: after this time without any sample a host or its link counts as lost; > heartbeat_deadline.
  std::chrono::nanoseconds host_lease = std::chrono::milliseconds(100);
  /// Liveliness lease between an active service and its standby; > heartbeat_period.
  std::chrono::nanoseconds failover_timeout = std::chrono::milliseconds(20);
  /// The agent restarts a process whose loop has sent no heartbeat for this time (six times that before the first one);
  /// 0: never.
  std::chrono::nanoseconds watchdog = std::chrono::seconds(10);
  /// Kinds of faults whose hold lasts until a person resumes the arms. The hold of other kinds ends with the fault.
  std::set<std::string, std::less<>> waits_for_resume = {"contact"};
};

/// The content of a cell file.
struct CellFile {
  std::string path;  ///< as given to load_cell_file
  planner::Cell cell;
  Network network;
  std::vector<Host> hosts;             ///< at least one, in the file's order
  std::vector<ArmHosts> arm_hosts;     ///< one per arm of the cell
  std::vector<DeviceOptions> devices;  ///< one per arm of the cell
  std::string world_host;
  Supervision supervision;
  planner::SourceFiles sources;    ///< the files that it was read from
  std::vector<std::string> notes;  ///< what the reader assumed or left out, a sentence each, for `hecaton check`
  bool real_time = false;          ///< loops of services get real-time priority where the machine allows it
};

/// Reads a cell file and checks that the cell can start: check_start(). `snapshot`: a folder of copies to read instead
/// (planner::SourceFiles). `methods`: the allowed values of the key `method`. `shapes`: the allowed types of obstacle
/// shapes, beside box and mesh. Throws ConfigError; std::invalid_argument if two shapes have the same name.
[[nodiscard]] CellFile load_cell_file(const std::string& path, const std::filesystem::path& snapshot = {},
                                      const planner::MethodRegistry& methods = planner::built_in_methods(),
                                      const std::vector<ShapeType>& shapes = shape_types());

/// The same for a text, as if the file `path` contained it: other files are relative to it, and messages name it.
[[nodiscard]] CellFile parse_cell_file(const std::string& text, const std::string& path,
                                       const planner::MethodRegistry& methods = planner::built_in_methods(),
                                       const std::vector<ShapeType>& shapes = shape_types());

}  // namespace hecaton::config
