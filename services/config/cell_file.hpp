#pragma once
/// A cell file (YAML): the cell, and the hosts of its services. docs/reference/cell-file.md lists every key.

#include <chrono>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/methods/registry.hpp"
#include "planner/model/source_file.hpp"
#include "services/config/shape_types.hpp"
#include "services/config/yaml_tree.hpp"

namespace hecaton::config {

/// How samples travel between processes.
enum class Transport {
  kUdp,           ///< between any hosts
  kSharedMemory,  ///< one host with one /dev/shm only
};

/// How processes find each other.
enum class Discovery {
  kMulticast,  ///< one announcement reaches all
  kUnicast,    ///< each process announces itself to the hosts' addresses and to `peers`
};

/// `network`.
struct Network {
  int domain = 42;                              ///< DDS domain, 0 to 199
  Transport transport = Transport::kUdp;        ///< of samples
  std::string interface;                        ///< address or name of the network interface to use; empty: all
  Discovery discovery = Discovery::kMulticast;  ///< how processes find each other
  std::vector<std::string> peers;               ///< IPv4 addresses of other machines to announce to; kUnicast only
  /// After this silence processes forget a process of the cell. Each announces itself ten times as often.
  std::chrono::milliseconds lease{2000};
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
  std::string type = "simulated";                          ///< a name of device_types()
  std::map<std::string, std::string, std::less<>> values;  ///< its other keys
  std::string where;                                       ///< "FILE: arms[0].device", the beginning of messages
};

/// A signal of an arm's device: an entry of `signals`.
struct SignalOptions {
  std::string name;   ///< unique on the arm
  std::string port;   ///< of the device: "digital_output 3"
  std::string where;  ///< "FILE: arms[0].signals.vacuum", the beginning of messages
};

/// Values of signals, by name.
using SignalValues = std::map<std::string, double, std::less<>>;

/// The gripper of an arm: `gripper`. Its opening is proportional to the positions of its joints.
struct Gripper {
  std::vector<std::string> joints;  ///< outside the chain, with a range; empty: the model has no fingers
  double closed = 0.0;              ///< position of these joints when it is closed [rad | m]
  double opened = 0.0;              ///< the same when it is open
  double width = 0.0;               ///< of its opening when it is open [m]; 0: not known
  double speed = 0.05;              ///< of the joints, where the device moves them [rad/s | m/s]
  SignalValues close;               ///< signals that close it; empty: the device moves the joints
  SignalValues open;                ///< signals that open it
  std::chrono::nanoseconds time = std::chrono::seconds(1);  ///< in which signals open or close it
  std::string where;                                        ///< "FILE: arms[0].gripper"
};

/// Tool and signals of an arm.
struct ToolOptions {
  std::vector<SignalOptions> signals;  ///< in the order of their names
  std::optional<Gripper> gripper;      ///< none: `hecaton tool` has nothing to move
};

/// The supervisor's hosts, and the time limits of fault detection.
struct Supervision {
  std::string host;          ///< of the supervisor
  std::string standby_host;  ///< of the standby supervisor; empty: none
  std::chrono::nanoseconds heartbeat_period = std::chrono::milliseconds(10);  ///< of every service's working loop
  /// After this time without heartbeat a loop counts as hanging; > heartbeat_period, whole milliseconds.
  std::chrono::nanoseconds heartbeat_deadline = std::chrono::milliseconds(20);
  /// Lease: after this time without any sample a host or its link counts as lost; > heartbeat_deadline.
  std::chrono::nanoseconds host_lease = std::chrono::milliseconds(100);
  /// Lease between an active service and its standby; > heartbeat_period.
  std::chrono::nanoseconds failover_timeout = std::chrono::milliseconds(20);
  /// The agent restarts a process whose loop has sent no heartbeat for this time (six times that before the first one);
  /// 0: never.
  std::chrono::nanoseconds watchdog = std::chrono::seconds(10);
  /// The agent restarts a process that uses more memory [byte]; 0: never. Services of three arms use 45 to 55 MB.
  std::uint64_t memory_limit = 1'000'000'000;
  /// Kinds of faults whose hold lasts until a person resumes the arms. The hold of other kinds ends with the fault.
  std::set<std::string, std::less<>> waits_for_resume = {"contact",         "device_not_ready", "remote_control_off",
                                                         "program_stopped", "safeguard_stop",   "protective_stop",
                                                         "emergency_stop",  "arm_failed"};
};

/// `view`: the service hecaton-view, which shows the cell in a browser.
struct View {
  std::string host;                  ///< of the service; its agent starts it
  std::string listen = "127.0.0.1";  ///< IPv4 address of the page; 0.0.0.0: all of the host
  std::optional<int> port;           ///< 1 to 65535; empty: view_port()
  bool control = false;              ///< one page at a time, with the token, gives orders
  bool no_stop = false;              ///< pages without control cannot stop the cell
  std::string certificate;           ///< path, PEM, with its chain; empty: one that the view makes itself
  std::string key;                   ///< path, PEM, of `certificate`
};

/// `record`: the service hecaton-recorder. It keeps the last minutes of the cell, and what was before and after a
/// fault.
struct Record {
  std::string host;                                                ///< of the service; its agent starts it
  std::string folder;                                              ///< of its files, on that host
  std::chrono::nanoseconds keep = std::chrono::minutes(10);        ///< older files are removed, unless they are saved
  std::chrono::nanoseconds after_fault = std::chrono::minutes(1);  ///< is saved, too
  std::uint64_t limit = 5'000'000'000;                             ///< of all its files together [byte]
  std::uint64_t split_size = 0;           ///< another file begins above it [byte]; 0: a tenth of `limit`
  std::chrono::nanoseconds split_time{};  ///< another file begins after it; 0: a tenth of `keep`, at most a minute
  bool ros2 = false;                      ///< with the topics of hecaton-ros2
};

/// The port of the page of a cell in this DDS domain, unless the cell file has another one. Cells of one machine run in
/// different domains, and so their pages have different ports.
[[nodiscard]] constexpr int view_port(int domain) {
  return 8000 + domain;
}

/// Other machines can connect to a page at this IPv4 address, so it is encrypted and asks for a token.
[[nodiscard]] bool is_reachable_by_others(const View& view);

/// What a user of that host types into a browser: "http://127.0.0.1:8042/". `domain`: of DDS.
[[nodiscard]] std::string view_url(const View& view, int domain);

/// The files that describe the robot of an arm, for programs that draw it.
struct RobotFiles {
  std::string urdf;                                    ///< path of the URDF or xacro file
  std::map<std::string, std::string> packages;         ///< as in planner::UrdfOptions
  std::map<std::string, std::string> xacro_arguments;  ///< as in planner::UrdfOptions
};

/// The layout of `ros_discovery_info`, which differs between distributions of ROS 2 although its type's name does not.
enum class Ros2Distribution {
  kHumble,  ///< identifiers of 24 bytes
  kJazzy,   ///< and Iron, Kilted: of 16 bytes
};

/// `ros2`: the service that shows the cell to ROS 2.
struct Ros2 {
  int domain = 0;                                ///< DDS domain of the ROS 2 nodes (ROS_DOMAIN_ID), 0 to 199
  std::optional<Ros2Distribution> distribution;  ///< empty: the service announces no node names
  std::string ns;                                ///< namespace "/cell1" of its topics; empty: none
  std::string host;                              ///< of the service
  std::string interface;                         ///< address or name of the network interface to use; empty: all
  double period = 0.02;                          ///< between two messages of joint states and transforms [s]
  bool control = false;                          ///< ROS 2 nodes may send goals and orders
  std::string enclave;                           ///< folder of its keys in that domain; empty: an open domain
};

/// The content of a cell file.
struct CellFile {
  std::string path;                    ///< as given to load_cell_file
  planner::Cell cell;                  ///< arms, obstacles, timing and tasks
  Network network;                     ///< of all processes
  std::string keystore;                ///< folder of the cell's keys; empty: an open cell
  std::vector<Host> hosts;             ///< at least one, in the file's order
  std::vector<ArmHosts> arm_hosts;     ///< one per arm of the cell
  std::vector<DeviceOptions> devices;  ///< one per arm of the cell
  std::vector<ToolOptions> tools;      ///< one per arm of the cell
  std::vector<RobotFiles> robots;      ///< one per arm of the cell
  std::string world_host;              ///< of the world service
  Supervision supervision;             ///< of the cell
  std::optional<View> view;            ///< empty: no agent starts it
  std::optional<Record> record;        ///< empty: no agent starts it
  std::optional<Ros2> ros2;            ///< empty: the cell has no such service
  planner::SourceFiles sources;        ///< the files that it was read from
  std::vector<std::string> notes;      ///< what the reader assumed or left out, a sentence each, for `hecaton check`
  bool real_time = false;              ///< loops of services get real-time priority where the machine allows it
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
