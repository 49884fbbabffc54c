#pragma once
/// A process's membership in a cell's DDS domain.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/rediscovery.hpp"

namespace hecaton::bus {

/// A participant's unicast ports depend on its number on the machine. Those of further participants belong to the next
/// domain.
inline constexpr int kMostParticipants = 119;

/// A machine to which a participant announces itself by unicast.
struct Peer {
  std::string address;  ///< IPv4
  /// The number of participants that the machine may have in the domain. Each has a port of its own, and the
  /// participant keeps sending announcements to so many ports.
  int participants = 64;
};

struct ParticipantOptions {
  /// Addresses of the interfaces to use, e.g. {"127.0.0.1"} for a cell on one host; empty: all.
  std::vector<std::string> interfaces;
  /// For networks that do not route multicast. Add this machine when its other participants are to be found. Empty:
  /// multicast.
  std::vector<Peer> peers;
  /// Shared memory beside UDP. It fails silently between containers and leaks when a process is killed.
  bool shared_memory = false;
  /// Peers drop a participant, with all its endpoints, that sends nothing for this long.
  std::chrono::milliseconds lease = kParticipantLease;
  /// Separates cells that share a domain; empty: the default partition.
  std::string partition;
  /// Announce the departure to peers; otherwise they drop this participant at the end of its lease. Switch it off for
  /// short-lived clients: Fast DDS 2.9.1 aborts a process that receives a departure while it checks that lease.
  bool announce_departure = true;
  /// Gets an event when a participant is found or lost; must outlive the participant.
  Mailbox* mailbox = nullptr;
  /// Called for each datagram to be sent, from several threads; true discards it. Empty: none is discarded.
  std::function<bool()> discard;
};

/// One per process is enough; endpoints keep it alive. Thread-safe.
class Participant {
 public:
  /// `name` is the one that peers see. A process can join a domain at least 3,700 times. Throws std::runtime_error with
  /// a sentence when the domain cannot be joined (0 ≤ domain ≤ 232; an interface that does not exist).
  Participant(int domain, const std::string& name, const ParticipantOptions& options = {});
  ~Participant();
  Participant(Participant&&) noexcept;
  Participant& operator=(Participant&&) noexcept;

  /// True from a long stall of this process (half the lease or more) until its peers are found again. Peers may have
  /// dropped it, so it sends and receives nothing until the lease is over on both sides. Do not judge or simulate by
  /// received data meanwhile.
  [[nodiscard]] bool recovering() const;

  struct Impl;
  [[nodiscard]] const std::shared_ptr<Impl>& impl() const { return impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

struct NetworkInterface {
  std::string name;
  std::string address;  ///< IPv4
};
/// The IPv4 addresses of this machine, with their interfaces. Empty when the kernel does not tell.
[[nodiscard]] std::vector<NetworkInterface> network_interfaces();

/// Removes the variables that name a Discovery Server from the environment of this process: ROS_DISCOVERY_SERVER, and
/// FASTDDS_ENVIRONMENT_FILE, a file that may set it. ROS 2 shells may name a server. Fast DDS then makes every
/// participant its client, and the cell's other participants do not discover it (docs/design/0012-discovery.md). Every
/// Participant does this before it joins. Returns the removed variables as "NAME=value". Thread-safe.
std::vector<std::string> ignore_discovery_servers();

}  // namespace hecaton::bus
