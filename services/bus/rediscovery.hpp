#pragma once
/// Timing of rediscovery: how participants that lost each other meet again (docs/explanation/0005-process-recovery.md).
/// `lease` is the one of the participant and of its peers. Standard library only.

#include <chrono>

namespace hecaton::bus {

constexpr std::chrono::milliseconds kParticipantLease{2000};

template <class Duration>
constexpr Duration announcement_period(Duration lease) {
  return lease / 10;  // so nine announcements in a row may be lost
}

/// A peer that is silent for this long is quarantined. It is most of the lease, so that a lossy link does not get
/// there.
template <class Duration>
constexpr Duration silence_limit(Duration lease) {
  return lease / 10 * 8;
}

/// The endpoints of a peer follow its first announcement within this time, also on a machine with too little processor
/// time. Otherwise only this side had dropped the peer.
template <class Duration>
constexpr Duration endpoint_limit(Duration lease) {
  return 3 * lease;
}

/// Duration of a quarantine. It is longer than the lease, because the other side hears nothing only from its begin.
template <class Duration>
constexpr Duration quarantine(Duration lease) {
  return lease + lease / 4;
}

/// Upper bound from the return of the link or the process to rediscovery: the other side may reach its silence limit in
/// that very instant, keeps its quarantine, and is then found by an announcement.
template <class Duration>
constexpr Duration longest_rediscovery(Duration lease) {
  return silence_limit(lease) + quarantine(lease) + announcement_period(lease);
}

/// A peer that has been received without a gap for this long after a loss will stay. If it had been close to its
/// silence limit, it would have heard an announcement by now or begun a quarantine and fallen silent.
template <class Duration>
constexpr Duration stable_contact(Duration lease) {
  return 5 * announcement_period(lease);
}

}  // namespace hecaton::bus
