#pragma once
/// When a sample was written, as its reader's history is told. Private to services/bus; standard library only.
///
/// Fast DDS 2.9.1 sorts what a reader has not been given yet by this time, but samples of one writer by their numbers.
/// As long as no writer's times go back that is one order. When a wall clock is set back it is none: a sample that came
/// after a lost one is put before it, the one that was repeated is not found when it is to be announced, and the reader
/// takes it all the same, at the next one of its key; there the library stops the process (an assertion in
/// DataReaderInstance::update_state), be it the command line's or a planner's. So these times are a wall clock's that
/// nobody can set: what it showed when the process first wrote, and the steady clock's time since.

#include <chrono>

namespace hecaton::bus {

class SourceTime {
 public:
  using Steady = std::chrono::steady_clock;
  using Wall = std::chrono::system_clock;

  SourceTime(Wall::time_point wall, Steady::time_point steady)
      : offset_(wall.time_since_epoch() - steady.time_since_epoch()) {}

  /// Since 1970, and never less than for an earlier instant.
  [[nodiscard]] std::chrono::nanoseconds at(Steady::time_point now) const { return now.time_since_epoch() + offset_; }

 private:
  std::chrono::nanoseconds offset_;
};

/// Of this process.
[[nodiscard]] inline std::chrono::nanoseconds source_time() {
  static const SourceTime kTime(SourceTime::Wall::now(), SourceTime::Steady::now());
  return kTime.at(SourceTime::Steady::now());
}

}  // namespace hecaton::bus
