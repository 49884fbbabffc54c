#pragma once
/// Compares the clocks of the hosts with the log time of a recording. Standard library only.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

namespace hecaton::services::recorder {

/// Of one host, in one second. The least latency of a message is part of each difference.
struct HostClock {
  std::uint64_t samples = 0;
  std::int64_t log_minus_publish = std::numeric_limits<std::int64_t>::max();  ///< the least: wall clock [ns]
  std::int64_t log_minus_stamp = std::numeric_limits<std::int64_t>::max();    ///< the least: steady clock [ns]
};

/// For one thread.
class HostClocks {
 public:
  static constexpr std::size_t kMostHosts = 128;  ///< further ones are not compared

  /// A heartbeat of a node of this host. `log_time`, `publish_time`: since 1970 [ns]; `stamp`: its stamp_ns.
  void note(const std::string& host, std::uint64_t log_time, std::uint64_t publish_time, std::int64_t stamp) {
    if (clocks_.size() >= kMostHosts && !clocks_.contains(host)) return;
    HostClock& clock = clocks_[host];
    ++clock.samples;
    clock.log_minus_publish = std::min(clock.log_minus_publish, difference(log_time, publish_time));
    clock.log_minus_stamp = std::min(clock.log_minus_stamp, difference(log_time, static_cast<std::uint64_t>(stamp)));
  }

  /// By host, of the heartbeats since the last call.
  [[nodiscard]] std::map<std::string, HostClock> take() {
    std::map<std::string, HostClock> clocks;
    clocks.swap(clocks_);
    return clocks;
  }

 private:
  /// Differences of clocks that are centuries apart wrap around.
  static std::int64_t difference(std::uint64_t a, std::uint64_t b) { return static_cast<std::int64_t>(a - b); }

  std::map<std::string, HostClock> clocks_;
};

/// Of one host in a recording. Positive offsets: its wall clock is behind the log time.
struct ClockFigures {
  static constexpr std::int64_t kStep = 100'000'000;  ///< smaller changes are slewed clocks, or latency [ns]

  std::uint64_t seconds = 0;  ///< in which heartbeats of the host arrived
  std::uint64_t samples = 0;
  std::int64_t last = 0;          ///< [ns]
  std::int64_t least = 0;         ///< [ns]
  std::int64_t most = 0;          ///< [ns]
  std::uint64_t steps = 0;        ///< of at least kStep
  std::int64_t largest_step = 0;  ///< positive: backward [ns]
  std::uint64_t stepped_at = 0;   ///< log time of the largest step [ns]

  void note(std::int64_t offset, std::uint64_t heartbeats, std::uint64_t log_time) {
    const bool first = seconds++ == 0;
    samples += heartbeats;
    least = first ? offset : std::min(least, offset);
    most = first ? offset : std::max(most, offset);
    const std::int64_t step = first ? 0 : offset - last;
    last = offset;
    if (magnitude(step) < kStep) return;
    ++steps;
    if (magnitude(step) <= magnitude(largest_step)) return;
    largest_step = step;
    stepped_at = log_time;
  }

 private:
  static std::int64_t magnitude(std::int64_t value) { return value < 0 ? -value : value; }
};

}  // namespace hecaton::services::recorder
