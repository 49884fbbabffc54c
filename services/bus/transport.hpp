#pragma once
/// How a participant reaches others: UDP, and shared memory only when asked for. Private to services/bus.

#include <memory>

#include "services/bus/fastdds.hpp"
#include "services/bus/gate_transport.hpp"
#include "services/bus/participant.hpp"

namespace hecaton::bus {

/// Of a domain on one host: the ports of the next one belong to the next domain.
constexpr int kMostParticipants = 119;

/// The participant can send once the gate that this returns is opened. Throws std::runtime_error when an interface does
/// not exist or a peer is no IPv4 address with 1 to 119 participants.
[[nodiscard]] std::shared_ptr<Gate> add_transports(dds::DomainParticipantQos& qos, int domain,
                                                   const ParticipantOptions& options);

}  // namespace hecaton::bus
