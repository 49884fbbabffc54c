#include "services/arm_driver/taken_ports.hpp"

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "services/arm_driver/device_choice.hpp"
#include "services/arm_driver/devices/socket.hpp"
#include "services/config/this_machine.hpp"

namespace hecaton::services {
namespace {

using device::Socket;

/// The name of a driver's process as the kernel has it: 15 letters.
constexpr std::string_view kDriverProcess = "hecaton-arm-dri";

bool binds(int type, in_addr address, int port) {
  const Socket socket(::socket(AF_INET, type | SOCK_CLOEXEC, 0));
  const int yes = 1;
  // As the device does: the port of a connection that has just ended is free.
  if (type == SOCK_STREAM) (void)::setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr = address;
  own.sin_port = htons(static_cast<std::uint16_t>(port));
  const bool bound = ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0 &&
                     (type != SOCK_STREAM || ::listen(socket.get(), 1) == 0);
  return bound || (errno != EADDRINUSE && errno != EADDRNOTAVAIL);
}

/// The sockets that are bound to the port, by the numbers of their inodes.
std::set<std::string> sockets_of(const device::ListeningPort& port) {
  constexpr std::string_view kListens = "0A";
  std::set<std::string> inodes;
  for (const char* table :
       {port.udp ? "/proc/net/udp" : "/proc/net/tcp", port.udp ? "/proc/net/udp6" : "/proc/net/tcp6"}) {
    std::ifstream lines(table);
    std::string line;
    std::getline(lines, line);  // the heading
    while (std::getline(lines, line)) {
      std::istringstream words(line);
      std::string number, local, remote, state, queues, timer, retransmits, user, timeout, inode;
      words >> number >> local >> remote >> state >> queues >> timer >> retransmits >> user >> timeout >> inode;
      const std::size_t colon = local.rfind(':');
      if (colon == std::string::npos || std::strtol(local.c_str() + colon + 1, nullptr, 16) != port.number) continue;
      if (port.udp || state == kListens) inodes.insert("socket:[" + inode + "]");
    }
  }
  return inodes;
}

struct Holder {
  std::string process;  ///< name
  std::string id;
};

/// Empty: it belongs to another user.
std::optional<Holder> holder_of(const device::ListeningPort& port) {
  namespace fs = std::filesystem;
  const std::set<std::string> sockets = sockets_of(port);
  std::error_code error;
  for (fs::directory_iterator process("/proc", error), end; !error && process != end; process.increment(error)) {
    const std::string id = process->path().filename();
    if (id.find_first_not_of("0123456789") != std::string::npos) continue;
    std::error_code unreadable;
    for (fs::directory_iterator file(process->path() / "fd", unreadable), last; !unreadable && file != last;
         file.increment(unreadable)) {
      std::error_code gone;
      if (!sockets.contains(fs::read_symlink(file->path(), gone).string())) continue;
      Holder holder{{}, id};
      std::ifstream name(process->path() / "comm");
      std::getline(name, holder.process);
      return holder;
    }
  }
  return std::nullopt;
}

}  // namespace

std::vector<TakenPort> taken_ports(const config::CellFile& file, std::span<const device::DeviceType> types) {
  std::vector<TakenPort> taken;
  in_addr any{};
  any.s_addr = htonl(INADDR_ANY);
  for (int arm = 0; arm < static_cast<int>(file.devices.size()); ++arm) {
    if (!config::is_this_machine(file, file.arm_hosts[arm].host)) continue;
    for (const device::ListeningPort& port : listening_ports(file, arm, types)) {
      if (binds(port.udp ? SOCK_DGRAM : SOCK_STREAM, any, port.number)) continue;
      const auto holder = holder_of(port);
      taken.push_back({file.devices[arm].where + "." + port.key + " = " + std::to_string(port.number) +
                           " must be a free port of this machine: " +
                           (holder ? holder->process + " (process " + holder->id + ")" : "another program") +
                           " holds " + (port.udp ? "UDP" : "TCP") + " port " + std::to_string(port.number) +
                           "; end that program, or set another port for arm " + file.cell.arms[arm].arm.name,
                       holder && holder->process == kDriverProcess});
    }
  }
  return taken;
}

}  // namespace hecaton::services
