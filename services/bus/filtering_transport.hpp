#pragma once
/// A participant's transports: UDP behind a filter for datagrams, and shared memory when asked for. Private to
/// services/bus.
///
/// Fast DDS 2.9.1 announces a new participant before its receiving threads can deliver messages
/// (RTPSParticipantImpl::enable). On a fast network the answers arrive within that moment and are lost, and peers do
/// not repeat them: in one start of five the newcomer knew no peer until the next periodic announcements. The filter
/// sends nothing before the participant is complete. It also isolates the process after a stall (LocalStallGuard) and
/// quarantined peers (PeerQuarantine), and sends fewer announcements (AnnouncementPacer). It drops malformed datagrams,
/// announced departures, and with keys what is not encrypted (DatagramCheck).

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "services/bus/announcement_pacer.hpp"
#include "services/bus/datagram_check.hpp"
#include "services/bus/deadlock_guard.hpp"
#include "services/bus/fastdds.hpp"
#include "services/bus/local_stall_guard.hpp"
#include "services/bus/participant.hpp"
#include "services/bus/peer_quarantine.hpp"
#include "services/bus/reception_gate.hpp"

namespace hecaton::bus {

/// Decides which datagrams one participant sends and receives. Thread-safe, but for the parts' update().
class DatagramFilter {
 public:
  /// `discard`: as in ParticipantOptions. `has_keys`, `multicast`: of the participant. The filter is closed at first.
  DatagramFilter(std::function<bool()> discard, Clock::duration lease, bool has_keys, bool multicast)
      : secured(has_keys),
        stall_guard(lease, Clock::now()),
        quarantine(lease),
        announcements(lease, multicast),
        discard_(std::move(discard)) {}

  void open() { open_ = true; }
  void close() { open_ = false; }
  /// Call it once for each datagram to be sent.
  [[nodiscard]] bool may_send() {
    if (!open_ || stall_guard.isolated(Clock::now())) return false;
    return !discard_ || !discard_();
  }
  /// Call it once for each received datagram.
  [[nodiscard]] bool may_receive() const { return !stall_guard.isolated(Clock::now()); }

  const bool secured;
  LocalStallGuard stall_guard;
  PeerQuarantine quarantine;
  AnnouncementPacer announcements;
  ReceiverWatchdog receivers;
  ReceptionGate gate;
  DatagramCheck datagrams;
  RefusalLog refusals;

 private:
  const std::function<bool()> discard_;
  std::atomic<bool> open_ = false;
};

/// The address of a UDP locator; its logical port number is the UDP port.
[[nodiscard]] PeerQuarantine::Address address_of(const rtps::Locator_t& locator);

/// "10.0.0.2"
[[nodiscard]] std::string address_text(const rtps::Locator_t& locator);

/// Adds the transports and the initial peers to `qos`. The participant sends once the returned filter is opened. Throws
/// std::runtime_error with a sentence when an interface does not exist or a peer is no IPv4 address with 1 to 119
/// participants.
[[nodiscard]] std::shared_ptr<DatagramFilter> add_transports(dds::DomainParticipantQos& qos, int domain,
                                                             const ParticipantOptions& options);

}  // namespace hecaton::bus
