#include "services/bus/transport.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <arpa/inet.h>
#include <ifaddrs.h>

namespace hecaton::bus {
namespace {

constexpr std::uint32_t kSendBuffer = 1U << 20U;  ///< [B] wanted

std::vector<std::string> local_addresses() {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return addresses;
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(list, &::freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    char text[INET_ADDRSTRLEN] = {};
    const auto* address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    if (::inet_ntop(AF_INET, &address->sin_addr, text, sizeof text) != nullptr) addresses.emplace_back(text);
  }
  return addresses;
}

void require_interfaces(const std::vector<std::string>& wanted) {
  const auto present = local_addresses();
  std::string all;
  for (const auto& address : present) all.append(all.empty() ? "" : ", ").append(address);
  for (const auto& address : wanted) {
    if (std::find(present.begin(), present.end(), address) != present.end()) continue;
    std::string sentence = "bus: interfaces: \"";
    sentence.append(address).append("\" is no address of this host (it has ").append(all).append(")");
    throw std::runtime_error(sentence);
  }
}

std::shared_ptr<rtps::UDPv4TransportDescriptor> udp(const ParticipantOptions& options) {
  auto descriptor = std::make_shared<rtps::UDPv4TransportDescriptor>();
  descriptor->interfaceWhiteList = options.interfaces;
  // Datagrams to a neighbour that does not answer wait in the kernel for seconds and fill the socket's buffer; a sender
  // that blocks there would keep a whole process from everybody else, on its own host, too. What does not fit is lost
  // like any datagram. The kernel gives as much of the buffer as net.core.wmem_max allows.
  descriptor->non_blocking_send = true;
  descriptor->sendBufferSize = kSendBuffer;
  return descriptor;
}

/// One locator for each participant that may be there. Without ports Fast DDS would try the first 4, or as many of
/// every peer as of the fullest.
void add_peer(dds::DomainParticipantQos& qos, int domain, const Peer& peer) {
  in_addr address{};
  if (::inet_pton(AF_INET, peer.address.c_str(), &address) != 1) {
    throw std::runtime_error("bus: peers: \"" + peer.address + "\" must be an IPv4 address, e.g. \"10.0.0.2\"");
  }
  if (peer.participants < 1 || peer.participants > kMostParticipants) {
    throw std::runtime_error("bus: peers: " + peer.address + ": participants = " + std::to_string(peer.participants) +
                             " must be between 1 and 119");
  }
  for (int id = 0; id < peer.participants; ++id) {
    rtps::Locator_t locator;
    locator.kind = LOCATOR_KIND_UDPv4;
    rtps::IPLocator::setIPv4(locator, peer.address);
    locator.port =
        qos.wire_protocol().port.getUnicastPort(static_cast<std::uint32_t>(domain), static_cast<std::uint32_t>(id));
    qos.wire_protocol().builtin.initialPeersList.push_back(locator);
  }
}

}  // namespace

std::shared_ptr<Gate> add_transports(dds::DomainParticipantQos& qos, int domain, const ParticipantOptions& options) {
  require_interfaces(options.interfaces);
  qos.transport().use_builtin_transports = false;
  auto gate = std::make_shared<Gate>(options.discard, options.lease);
  qos.transport().user_transports.push_back(std::make_shared<GateDescriptor>(udp(options), gate));
  if (options.shared_memory) {
    qos.transport().user_transports.push_back(std::make_shared<rtps::SharedMemTransportDescriptor>());
  }
  for (const Peer& peer : options.peers) add_peer(qos, domain, peer);
  return gate;
}

}  // namespace hecaton::bus
