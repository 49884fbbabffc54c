#pragma once
/// A process's membership in a cell's DDS domain.

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/rediscovery.hpp"
#include "services/bus/refusals.hpp"

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

/// The first six bytes of the GUID of a participant with keys. They are 1 and 47 bits of the SHA-256 of its
/// certificate's subject (DDS Security 1.1, section 9.3.3); a handshake fails when they are not.
using GuidBeginning = std::array<std::uint8_t, 6>;

/// How a participant joins its domain.
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
  /// The planners and supervisors of the cell: only participants of these names count as such (Participant::refused()
  /// names others that write their messages). Empty: any name counts.
  std::vector<std::string> nodes;
  /// Announced to peers as the participant's USER_DATA; empty: none.
  std::string user_data;
  /// Folder with the keys of this participant (services/security/keystore.hpp): DDS Security authenticates its peers,
  /// enforces their permissions and encrypts. It then leaves silently. Empty: an open participant.
  std::filesystem::path identity;
  /// When the first of these keys expires; empty: an open participant.
  std::optional<std::chrono::system_clock::time_point> identity_expires;
  /// File of the authority's list of revoked certificates, for handshakes. It is read once. Empty: there is none.
  std::filesystem::path revocations;
  /// Returns the beginnings of the GUIDs of revoked participants. The participant calls it once a second, in a thread
  /// of its own, and ends its exchange with those that are new. Empty: none is revoked later.
  std::function<std::vector<GuidBeginning>()> revoked;
  /// Announce the departure of the endpoints to peers; otherwise they drop them with this participant at the end of its
  /// lease. Short-lived clients do without.
  bool announce_departure = true;
  /// For a process that only watches. A receiving thread that had to wait for a datagram then sleeps for this long, and
  /// takes all that has come meanwhile at once. So it wakes a few times for hundreds of datagrams; each wake-up of it
  /// would interrupt a loop, and cost the sender time. What it receives is late by so much. 0: it never sleeps.
  std::chrono::milliseconds reception_pause{0};
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
  Participant(Participant&&) noexcept;             ///< a participant from which another was moved may only be destroyed
  Participant& operator=(Participant&&) noexcept;  ///< leaves the domain of the participant that it had

  /// True from a long stall of this process (half the lease or more) until its peers are found again. Peers may have
  /// dropped it, so it sends and receives nothing until the lease is over on both sides. Do not judge or simulate by
  /// received data meanwhile.
  [[nodiscard]] bool recovering() const;

  /// The names of participants that were found and cannot be heard. With keys the handshake is under way. Without keys
  /// they have no endpoint that matches: theirs is another partition, or they have keys.
  [[nodiscard]] std::vector<std::string> joining() const;

  /// ParticipantOptions::identity_expires
  [[nodiscard]] std::optional<std::chrono::system_clock::time_point> identity_expires() const;

  /// The process remembers this term from an earlier one: samples with terms far above it are refused (wire_rules.hpp).
  void know_term(std::uint64_t term);

  /// What was refused in the last `window`, by sender, the most recent first, at most `most`.
  [[nodiscard]] std::vector<Refused> refused(Clock::duration window, std::size_t most) const;
  /// A service refuses a sample for a reason that the bus does not know; see Refused.
  void refuse(Refused refused);

  struct Impl;
  [[nodiscard]] const std::shared_ptr<Impl>& impl() const { return impl_; }  ///< for endpoints

 private:
  std::shared_ptr<Impl> impl_;
};

/// An interface of this machine.
struct NetworkInterface {
  std::string name;     ///< as `ip link` shows it
  std::string address;  ///< IPv4
};
/// The IPv4 addresses of this machine, with their interfaces. Empty when the kernel does not tell.
[[nodiscard]] std::vector<NetworkInterface> network_interfaces();

/// Removes the variables that name a Discovery Server from the environment of this process: ROS_DISCOVERY_SERVER, and
/// FASTDDS_ENVIRONMENT_FILE, a file that may set it. ROS 2 shells may name a server. Fast DDS then makes every
/// participant its client, and the cell's other participants do not discover it (docs/explanation/0012-discovery.md).
/// Every Participant does this before it joins. Returns the removed variables as "NAME=value". Thread-safe.
std::vector<std::string> ignore_discovery_servers();

}  // namespace hecaton::bus
