#include "services/runtime/peers.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>

#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

/// Commands of people and programs beside the cell's own processes on a machine.
constexpr int kClients = 8;
constexpr int kMostParticipants = 119;  ///< of a machine in a DDS domain

/// IPv4; empty, with a warning, when there is none.
std::string resolved(const config::Host& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* list = nullptr;
  const int error = getaddrinfo(host.address.c_str(), nullptr, &hints, &list);
  if (error != 0) {
    log_warning("a host's name cannot be resolved: this process does not announce itself there, and waits to be found",
                {{"key", "hosts." + host.name}, {"name", host.address}, {"reason", gai_strerror(error)}});
    return {};
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(list, freeaddrinfo);
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto* address = reinterpret_cast<const sockaddr_in*>(list->ai_addr);
  inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
  return text.data();
}

/// Participants that the cell file places on each host, by the host's name.
std::map<std::string, int> placed(const config::CellFile& file) {
  std::map<std::string, int> count;
  for (const config::Host& host : file.hosts) count[host.name] = 1;  // its agent
  ++count[file.world_host];
  ++count[file.supervision.host];
  if (!file.supervision.standby_host.empty()) ++count[file.supervision.standby_host];
  for (const config::ArmHosts& arm : file.arm_hosts) {
    count[arm.host] += 2;  // driver and planner
    if (!arm.standby_host.empty()) ++count[arm.standby_host];
  }
  return count;
}

/// Each address once, with all who may be there.
class Peers {
 public:
  void add(const std::string& address, int participants) {
    if (!address.empty()) participants_[address] += participants;
  }
  void at_least(const std::string& address, int participants) {
    participants_[address] = std::max(participants_[address], participants);
  }
  [[nodiscard]] std::vector<bus::Peer> list() const {
    std::vector<bus::Peer> peers;
    for (const auto& [address, participants] : participants_) {
      peers.push_back({address, std::min(participants + kClients, kMostParticipants)});
    }
    return peers;
  }

 private:
  std::map<std::string, int> participants_;
};

}  // namespace

std::vector<bus::Peer> peers_of(const config::CellFile& file, const std::vector<std::string>& interfaces) {
  if (file.network.discovery == config::Discovery::kMulticast) return {};
  const auto count = placed(file);
  Peers peers;
  int everybody = 0;
  for (const config::Host& host : file.hosts) {
    peers.add(resolved(host), count.at(host.name));
    everybody += count.at(host.name);
  }
  // All of the cell may run on this machine, whatever the addresses say: to try it out.
  const auto here = interfaces.empty() ? std::vector<std::string>{"127.0.0.1"} : interfaces;
  for (const std::string& address : here) peers.at_least(address, everybody);
  for (const std::string& address : file.network.peers) peers.at_least(address, everybody);
  return peers.list();
}

}  // namespace hecaton::services
