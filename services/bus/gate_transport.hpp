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
  /// `lose_one_in`: for tests; 0: nothing is lost.
  Gate(int lose_one_in, Clock::duration lease)
      : absence(lease, Clock::now()), hearing(lease), lose_one_in_(static_cast<std::uint64_t>(lose_one_in)) {}

  void open() { open_ = true; }
  void close() { open_ = false; }
  /// Asked once for each datagram that is sent.
  [[nodiscard]] bool lets_out() {
    if (!open_ || absence.away(Clock::now())) return false;
    return lose_one_in_ == 0 || mixed(++sent_) % lose_one_in_ != 0;
  }
  /// Asked once for each datagram that has come.
  [[nodiscard]] bool lets_in() const { return !absence.away(Clock::now()); }

  Absence absence;
  Hearing hearing;
  Receivers receivers;

 private:
  /// Losing every n-th would lose the same message of a periodic protocol again and again. [Steele14]
  static std::uint64_t mixed(std::uint64_t z) {
    z *= 0x9E37'79B9'7F4A'7C15ULL;
    z = (z ^ (z >> 30)) * 0xBF58'476D'1CE4'E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D0'49BB'1331'11EBULL;
    return z ^ (z >> 31);
  }

  const std::uint64_t lose_one_in_;
  std::atomic<bool> open_ = false;
  std::atomic<std::uint64_t> sent_ = 0;
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
