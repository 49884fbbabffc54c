#include "services/runtime/join.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <netinet/in.h>

#include "services/bus/topics.hpp"

namespace hecaton::services {
namespace {

bool is_address(const std::string& text) {
  in_addr parsed{};
  return inet_pton(AF_INET, text.c_str(), &parsed) == 1;
}

/// The IPv4 addresses of the machine's interface `name`.
std::vector<std::string> addresses_of(const std::string& name) {
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner(list, freeifaddrs);
  std::vector<std::string> addresses;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (name != entry->ifa_name || entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    inet_ntop(AF_INET, &address->sin_addr, text, sizeof text);
    addresses.emplace_back(text);
  }
  return addresses;
}

std::vector<std::string> interfaces(const config::CellFile& file) {
  const std::string& wanted = file.network.interface;
  if (wanted.empty()) return {};
  if (is_address(wanted)) return {wanted};
  auto addresses = addresses_of(wanted);
  if (addresses.empty()) {
    throw std::runtime_error(file.path + ": network.interface = " + wanted +
                             " must be the address or the name of a network interface of this machine");
  }
  return addresses;
}

}  // namespace

bus::Participant make_participant(const config::CellFile& file, const ServiceOptions& options, const std::string& node,
                                  bus::Mailbox* mailbox) {
  bus::ParticipantOptions participant;
  participant.interfaces = interfaces(file);
  participant.peers = file.network.peers;
  participant.shared_memory = file.network.transport == config::Transport::kSharedMemory;
  participant.partition = file.cell.name;
  participant.mailbox = mailbox;
  return {choose_domain(options, file.network.domain), node, participant};
}

PulseTiming pulse_timing(const config::CellFile& file) {
  constexpr bus::Qos kAsked = bus::Topic<msg::Heartbeat>::kInfo.qos;
  const auto at_most = [](std::chrono::nanoseconds wanted, std::chrono::milliseconds limit) {
    return std::min(std::chrono::ceil<std::chrono::milliseconds>(wanted), limit);
  };
  return {file.supervision.heartbeat_period, at_most(file.supervision.heartbeat_deadline, kAsked.deadline),
          at_most(file.supervision.host_lease, kAsked.lease)};
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
