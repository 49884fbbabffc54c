#include "services/runtime/join.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include "services/bus/discovery_server.hpp"
#include "services/bus/topics.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/peers.hpp"

namespace hecaton::services {
namespace {

struct Interface {
  std::string name;
  std::string address;  ///< IPv4
};

std::vector<Interface> interfaces_of_this_machine() {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, freeifaddrs);
  std::vector<Interface> found;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    inet_ntop(AF_INET, &address->sin_addr, text, sizeof text);
    found.push_back({entry->ifa_name, text});
  }
  return found;
}

/// Addresses of the interface that the cell file wants; empty: of all.
std::vector<std::string> wanted_interfaces(const config::CellFile& file) {
  const std::string& wanted = file.network.interface;
  if (wanted.empty()) return {};
  std::vector<std::string> addresses;
  std::string all;
  for (const Interface& one : interfaces_of_this_machine()) {
    if (one.name == wanted || one.address == wanted) addresses.push_back(one.address);
    all.append(all.empty() ? "" : ", ").append(one.name).append(" (").append(one.address).append(")");
  }
  if (addresses.empty()) {
    throw std::runtime_error(file.path + ": network.interface = " + wanted +
                             " must be the name or the address of a network interface of this machine: " + all);
  }
  return addresses;
}

}  // namespace

void require_interface(const config::CellFile& file) {
  static_cast<void>(wanted_interfaces(file));
}

bus::ParticipantOptions participant_options(const config::CellFile& file) {
  bus::ParticipantOptions participant;
  participant.interfaces = wanted_interfaces(file);
  participant.peers = peers_of(file, participant.interfaces);
  participant.shared_memory = file.network.transport == config::Transport::kSharedMemory;
  participant.partition = file.cell.name;
  return participant;
}

bus::Participant make_participant(const config::CellFile& file, const ServiceOptions& options, const std::string& node,
                                  bus::Mailbox* mailbox) {
  for (const std::string& server : bus::ignore_discovery_servers()) {
    log_warning("environment is ignored: a cell has no Discovery Server", {{"variable", server}});
  }
  bus::ParticipantOptions participant = participant_options(file);
  participant.mailbox = mailbox;
  return {choose_domain(options, file.network.domain), node, participant};
}

PulseTiming pulse_timing(const config::CellFile& file, const ServiceOptions& options) {
  constexpr bus::Qos kAsked = bus::Topic<msg::Heartbeat>::kInfo.qos;
  const auto at_most = [](std::chrono::nanoseconds wanted, std::chrono::milliseconds limit) {
    return std::min(std::chrono::ceil<std::chrono::milliseconds>(wanted), limit);
  };
  return {file.supervision.heartbeat_period, at_most(file.supervision.heartbeat_deadline, kAsked.deadline),
          at_most(file.supervision.host_lease, kAsked.lease), options.alive_fd};
}

int find_arm(const config::CellFile& file, const std::string& name) {
  std::string names;
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    const std::string& candidate = file.cell.arms[i].arm.name;
    if (candidate == name) return static_cast<int>(i);
    names += (i == 0 ? "" : ", ") + candidate;
  }
  throw std::runtime_error(file.path + ": --arm " + name + " must be one of " + names);
}

}  // namespace hecaton::services
