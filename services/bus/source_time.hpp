#pragma once
/// The source time of written samples. Private to services/bus; standard library only.
///
/// Fast DDS 2.9.1 sorts the samples that a reader has not taken by their source time, but the samples of one writer by
/// their numbers. The two orders agree as long as no writer's time goes back. After a step back of the wall clock, a
/// sample behind a lost one is sorted before it. The repetition of the lost one is then not found when it is announced.
/// At the next sample of the key an assertion in DataReaderInstance::update_state ends the process. So source times
/// come from a clock that cannot be set: the wall clock at the process's first write plus the steady clock's time
/// since.

#include <chrono>

namespace hecaton::bus {

class SourceTime {
 public:
  using Steady = std::chrono::steady_clock;
  using Wall = std::chrono::system_clock;

  SourceTime(Wall::time_point wall, Steady::time_point steady)
      : offset_(wall.time_since_epoch() - steady.time_since_epoch()) {}

  /// Time since 1970. Never less than for an earlier instant.
  [[nodiscard]] std::chrono::nanoseconds at(Steady::time_point now) const { return now.time_since_epoch() + offset_; }

 private:
  std::chrono::nanoseconds offset_;
};

/// The source time of a sample that this process writes now. Thread-safe.
[[nodiscard]] inline std::chrono::nanoseconds source_time() {
  static const SourceTime kTime(SourceTime::Wall::now(), SourceTime::Steady::now());
  return kTime.at(SourceTime::Steady::now());
}

}  // namespace hecaton::bus
