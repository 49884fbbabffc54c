#include "services/bus/filtering_transport.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string_view>
#include <thread>
#include <utility>

#include <arpa/inet.h>
#include <sys/resource.h>

namespace hecaton::bus {
namespace {

struct FilteringTransportDescriptor : rtps::ChainingTransportDescriptor {
  FilteringTransportDescriptor(std::shared_ptr<rtps::TransportDescriptorInterface> behind,
                               std::shared_ptr<DatagramFilter> its_filter, std::chrono::milliseconds pause)
      : ChainingTransportDescriptor(std::move(behind)), filter(std::move(its_filter)), reception_pause(pause) {}

  [[nodiscard]] rtps::TransportInterface* create_transport() const override;

  std::shared_ptr<DatagramFilter> filter;
  std::chrono::milliseconds reception_pause;
};

/// How often this thread has given its processor away to wait; that another thread took it does not count.
long waits_of_this_thread() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return usage.ru_nvcsw;
}

class FilteringTransport : public FrontTransport {
 public:
  explicit FilteringTransport(const FilteringTransportDescriptor& descriptor)
      : FrontTransport(descriptor),
        descriptor_(descriptor),
        filter_(descriptor.filter),
        pause_(descriptor.reception_pause) {}

  [[nodiscard]] rtps::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }

  bool pass_on(const Datagram& datagram, rtps::SenderResource& behind, rtps::LocatorsIterator& begin,
               rtps::LocatorsIterator& end, const std::chrono::steady_clock::time_point& until) override {
    if (!filter_->may_send()) return true;
    const bool paced = filter_->announcements.active() && is_announcement(datagram);
    if (!paced && !filter_->quarantine.any_quarantined()) return datagram.send(behind, begin, end, until);
    const auto now = Clock::now();
    rtps::LocatorList others;
    for (; begin != end; ++begin) {
      if (filter_->quarantine.is_quarantined(address_of(*begin))) continue;
      if (paced && !filter_->announcements.is_due(address_of(*begin), now)) continue;
      others.push_back(*begin);
    }
    rtps::Locators first(others.begin());
    rtps::Locators last(others.end());
    return others.empty() || datagram.send(behind, first, last, until);
  }

  void receive(rtps::TransportReceiverInterface* next, const rtps::octet* data, std::uint32_t size,
               const rtps::Locator_t& local, const rtps::Locator_t& remote) override {
    if (pause_.count() == 0) return take(next, data, size, local, remote);
    // Each receiving thread is of one participant. Between two datagrams it waits for nothing but the second one.
    thread_local long waits = 0;
    const bool waited = waits_of_this_thread() != waits;
    take(next, data, size, local, remote);
    if (waited) std::this_thread::sleep_for(pause_);
    waits = waits_of_this_thread();
  }

 private:
  void take(rtps::TransportReceiverInterface* next, const rtps::octet* data, std::uint32_t size,
            const rtps::Locator_t& local, const rtps::Locator_t& remote) {
    thread_local ReceptionStall stall;
    const Clock::time_point now = Clock::now();
    stall.read(now);
    if (!filter_->may_receive()) return;
    // RTPS header: "RTPS", version, vendor, then the sender's prefix.
    PeerQuarantine::Prefix sender{};
    constexpr std::size_t kPrefixAt = 8;
    if (size < kPrefixAt + sender.size()) return;
    std::copy_n(data + kPrefixAt, sender.size(), sender.begin());
    if (filter_->secured) {
      const auto protection = DatagramCheck::protection({data, size});
      if (protection == DatagramCheck::Protection::kForged) return refuse(sender, "it is not encrypted", remote);
      if (protection == DatagramCheck::Protection::kMissing) return;
    }
    if (const auto malformed = filter_->datagrams.refuse({data, size}, address_of(remote), now, stall.ended())) {
      return refuse(sender, *malformed, remote);
    }
    if (filter_->quarantine.is_revoked(sender)) return refuse(sender, "its keys are revoked", remote);
    if (!filter_->quarantine.accepts(sender, Clock::now())) return;
    if (DatagramCheck::announces_departure({data, size})) return;
    const ReceptionGate::Pass pass(filter_->gate);
    const std::size_t slot = filter_->receivers.enter(Clock::now());
    next->OnDataReceived(data, size, local, remote);
    filter_->receivers.leave(slot);
  }

  static bool is_announcement(const Datagram& datagram) {
    std::array<std::uint8_t, AnnouncementPacer::kHead> head{};
    return AnnouncementPacer::is_announcement({head.data(), datagram.copy_head(head)});
  }

  void refuse(const PeerQuarantine::Prefix& sender, std::string_view text, const rtps::Locator_t& remote) {
    Refused refused;
    std::copy(sender.begin(), sender.end(), refused.sender.bytes.begin());
    refused.text = text;
    refused.address = address_text(remote);
    refused.last = Clock::now();
    filter_->refusals.note(std::move(refused));
  }

  FilteringTransportDescriptor descriptor_;
  std::shared_ptr<DatagramFilter> filter_;
  const std::chrono::milliseconds pause_;
};

rtps::TransportInterface* FilteringTransportDescriptor::create_transport() const {
  return new FilteringTransport(*this);
}

constexpr std::uint32_t kSendBuffer = 1U << 20U;     ///< requested [byte]
constexpr std::uint32_t kReceiveBuffer = 1U << 20U;  ///< requested [byte]

void require_interfaces(const std::vector<std::string>& wanted) {
  const auto present = network_interfaces();
  std::string all;
  for (const auto& one : present) all.append(all.empty() ? "" : ", ").append(one.address);
  for (const auto& address : wanted) {
    if (std::any_of(present.begin(), present.end(), [&](const auto& one) { return one.address == address; })) continue;
    std::string sentence = "bus: interfaces: \"";
    sentence.append(address).append("\" must be an address of this host: ").append(all);
    throw std::runtime_error(sentence);
  }
}

std::shared_ptr<rtps::UDPv4TransportDescriptor> udp(const ParticipantOptions& options) {
  auto descriptor = std::make_shared<rtps::UDPv4TransportDescriptor>();
  descriptor->interfaceWhiteList = options.interfaces;
  // Datagrams to a neighbour that does not answer wait in the kernel for seconds and fill the socket's buffer. A sender
  // that blocks there would cut the process off from all peers, on its own host, too. Datagrams that do not fit are
  // lost. The kernel grants the buffer up to net.core.wmem_max.
  descriptor->non_blocking_send = true;
  descriptor->sendBufferSize = kSendBuffer;
  // The default of Linux holds some 200 datagrams: a busy machine that delays the receiving thread for 0.2 s loses
  // further ones. The kernel grants the buffer up to net.core.rmem_max.
  descriptor->receiveBufferSize = kReceiveBuffer;
  return descriptor;
}

/// Adds one locator for each participant that the peer's machine may have. Without ports Fast DDS would try the first
/// 4, or on every machine as many as on the fullest.
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

std::string address_text(const rtps::Locator_t& locator) {
  std::string text;
  for (int i = 12; i < 16; ++i)
    text += (text.empty() ? "" : ".") + std::to_string(static_cast<int>(locator.address[i]));
  return text;
}

PeerQuarantine::Address address_of(const rtps::Locator_t& locator) {
  std::uint32_t ipv4 = 0;
  for (int i = 12; i < 16; ++i) ipv4 = ipv4 << 8U | locator.address[i];
  return PeerQuarantine::address_of(ipv4, static_cast<std::uint16_t>(locator.port));
}

std::shared_ptr<DatagramFilter> add_transports(dds::DomainParticipantQos& qos, int domain,
                                               const ParticipantOptions& options) {
  require_interfaces(options.interfaces);
  qos.transport().use_builtin_transports = false;
  auto filter = std::make_shared<DatagramFilter>(options.discard, options.lease, !options.identity.empty(),
                                                 options.peers.empty());
  qos.transport().user_transports.push_back(
      std::make_shared<FilteringTransportDescriptor>(udp(options), filter, options.reception_pause));
  if (options.shared_memory) {
    qos.transport().user_transports.push_back(std::make_shared<rtps::SharedMemTransportDescriptor>());
  }
  for (const Peer& peer : options.peers) add_peer(qos, domain, peer);
  return filter;
}

}  // namespace hecaton::bus
