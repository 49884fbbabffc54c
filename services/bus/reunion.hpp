#pragma once
/// How participants that lost each other meet again, and how long that takes at most (docs/design/0005-return.md).
/// Standard library only. `lease`: of the participant and of its peers.

#include <chrono>

namespace hecaton::bus {

constexpr std::chrono::milliseconds kParticipantLease{2000};

template <class Duration>
constexpr Duration announcement_period(Duration lease) {
  return lease / 10;  // as many may be lost in a row
}

/// Who is not heard for so long is left alone: most of the lease, so that a lossy link does not get that far where
/// announcements come ten times in it.
template <class Duration>
constexpr Duration patience(Duration lease) {
  return lease / 10 * 8;
}

/// For so long: surely longer than the lease, for the other side begins to hear nothing only now.
template <class Duration>
constexpr Duration quarantine(Duration lease) {
  return lease + lease / 4;
}

/// From the instant in which the link is back, or the process goes on: who is left alone by the other in that very
/// instant loses patience first, and is then found with an announcement.
template <class Duration>
constexpr Duration longest_reunion(Duration lease) {
  return patience(lease) + quarantine(lease) + announcement_period(lease);
}

/// Who has been heard for so long without a gap after a loss is met for good. The other side, which may have been about
/// to lose patience with us, has heard an announcement of ours by then, or left us alone, and is heard no more.
template <class Duration>
constexpr Duration sure_meeting(Duration lease) {
  return 5 * announcement_period(lease);
}

}  // namespace hecaton::bus
