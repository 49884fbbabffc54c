#include "services/bus/transport.hpp"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include <arpa/inet.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#include <ifaddrs.h>

namespace hecaton::bus {
namespace {

namespace transports = eprosima::fastdds::rtps;

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

std::shared_ptr<transports::UDPv4TransportDescriptor> udp(const ParticipantOptions& options) {
  auto descriptor = std::make_shared<transports::UDPv4TransportDescriptor>();
  descriptor->interfaceWhiteList = options.interfaces;
  descriptor->maxInitialPeersRange = static_cast<std::uint32_t>(options.participants_per_peer);
  return descriptor;
}

}  // namespace

std::shared_ptr<Gate> add_transports(eprosima::fastdds::dds::DomainParticipantQos& qos,
                                     const ParticipantOptions& options) {
  require_interfaces(options.interfaces);
  qos.transport().use_builtin_transports = false;
  auto gate = std::make_shared<Gate>(options.lose_one_in, options.lease);
  qos.transport().user_transports.push_back(std::make_shared<GateDescriptor>(udp(options), gate));
  if (options.shared_memory) {
    qos.transport().user_transports.push_back(std::make_shared<transports::SharedMemTransportDescriptor>());
  }
  for (const auto& peer : options.peers) {
    in_addr address{};
    if (::inet_pton(AF_INET, peer.c_str(), &address) != 1) {
      throw std::runtime_error("bus: peers: \"" + peer + "\" must be an IPv4 address, e.g. \"10.0.0.2\"");
    }
    eprosima::fastrtps::rtps::Locator_t locator;  // port 0: those of the first `participants_per_peer` participants
    locator.kind = LOCATOR_KIND_UDPv4;
    eprosima::fastrtps::rtps::IPLocator::setIPv4(locator, peer);
    qos.wire_protocol().builtin.initialPeersList.push_back(locator);
  }
  return gate;
}

}  // namespace hecaton::bus
