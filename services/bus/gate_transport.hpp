#pragma once
/// A transport behind a gate that opens when the participant is ready. Private to services/bus.
///
/// Fast DDS 2.9.1 announces a new participant before its receiving threads have anybody to give messages to
/// (RTPSParticipantImpl::enable). On a fast network the answers arrive within that moment and are lost, and nobody
/// answers twice: in one start of five the newcomer knew nobody until their next periodic announcement. Behind the gate
/// nothing leaves before everything is in place. It is shut in both directions while the process is absent, and for
/// peers that fell silent.

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "services/bus/absence.hpp"
#include "services/bus/fastdds.hpp"
#include "services/bus/hearing.hpp"
#include "services/bus/receivers.hpp"

namespace hecaton::bus {

/// What one participant may send and hear.
class Gate {
 public:
  /// `discard`: as in ParticipantOptions.
  Gate(std::function<bool()> discard, Clock::duration lease)
      : absence(lease, Clock::now()), hearing(lease), discard_(std::move(discard)) {}

  void open() { open_ = true; }
  void close() { open_ = false; }
  /// Asked once for each datagram that is sent.
  [[nodiscard]] bool lets_out() {
    if (!open_ || absence.away(Clock::now())) return false;
    return !discard_ || !discard_();
  }
  /// Asked once for each datagram that has come.
  [[nodiscard]] bool lets_in() const { return !absence.away(Clock::now()); }

  Absence absence;
  Hearing hearing;
  Receivers receivers;

 private:
  const std::function<bool()> discard_;
  std::atomic<bool> open_ = false;
};

/// Of a UDP locator; its logical port number is the UDP port.
[[nodiscard]] Hearing::Address address_of(const rtps::Locator_t& locator);

struct GateDescriptor : rtps::ChainingTransportDescriptor {
  GateDescriptor(std::shared_ptr<rtps::TransportDescriptorInterface> behind, std::shared_ptr<Gate> its_gate)
      : ChainingTransportDescriptor(std::move(behind)), gate(std::move(its_gate)) {}

  [[nodiscard]] rtps::TransportInterface* create_transport() const override;

  std::shared_ptr<Gate> gate;
};

}  // namespace hecaton::bus
