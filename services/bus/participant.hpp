#pragma once
/// A process's membership in a cell's DDS domain. Endpoints keep the membership alive; one per process is enough.

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/bus/reunion.hpp"

namespace hecaton::bus {

/// A machine to announce ourselves to by unicast.
struct Peer {
  std::string address;  ///< IPv4
  /// How many participants of the domain may be there: each has a port of its own, and as many are tried, for ever.
  int participants = 64;
};

struct ParticipantOptions {
  /// Addresses of the interfaces to use, e.g. {"127.0.0.1"} for a cell on one host; empty: all.
  std::vector<std::string> interfaces;
  /// Where multicast is not routed. Must include this machine when others on it are to be found. Empty: multicast.
  std::vector<Peer> peers;
  /// Shared memory beside UDP. Off: it fails silently between containers and leaks when a process is killed.
  bool shared_memory = false;
  /// A participant that says nothing this long is taken for gone, with all its endpoints.
  std::chrono::milliseconds lease = kParticipantLease;
  /// Cells that share a domain are kept apart by this name; empty: the default partition.
  std::string partition;
  /// Others are told when we leave; otherwise they notice after the lease. For who comes and goes often: in Fast
  /// DDS 2.9.1 a process aborts when it hears of a departure in the instant in which the leaver's lease is due to be
  /// looked at.
  bool farewell = true;
  /// Told when participants come and go; must outlive the participant.
  Mailbox* mailbox = nullptr;
  /// Called for each datagram that this participant sends, from several threads; true discards it. Empty: none is.
  std::function<bool()> discard;
};

class Participant {
 public:
  /// `name` is what others see. A process can join at least 3,700 times. Throws std::runtime_error with a sentence when
  /// the domain cannot be joined (0 ≤ domain ≤ 232; an interface that does not exist).
  Participant(int domain, const std::string& name, const ParticipantOptions& options = {});
  ~Participant();
  Participant(Participant&&) noexcept;
  Participant& operator=(Participant&&) noexcept;

  /// This process was stopped for so long (half the lease or more) that others may have dropped us: nothing is sent
  /// and nothing received until the lease is over on both sides and the others are found again. Who judges or
  /// simulates by what it hears should do neither meanwhile.
  [[nodiscard]] bool away() const;

  struct Impl;
  [[nodiscard]] const std::shared_ptr<Impl>& impl() const { return impl_; }

 private:
  std::shared_ptr<Impl> impl_;
};

}  // namespace hecaton::bus
