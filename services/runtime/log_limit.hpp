#pragma once
/// How many lines of one event a log takes: floods of orders must not fill a disk.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace hecaton::services {

/// A bucket of lines for each event: it holds kAtOnce lines, and gets kEachSecond. At 200 bytes a line an event adds at
/// most 90 MB a day. Not thread-safe.
class LogLimit {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr double kAtOnce = 200.0;
  static constexpr double kEachSecond = 5.0;

  /// Empty: the line is left out. Otherwise the number of lines of this event that were left out before it.
  std::optional<std::uint64_t> admit(std::string_view event, Time now) {
    auto found = buckets_.find(event);
    if (found == buckets_.end()) found = buckets_.emplace(std::string(event), Bucket{kAtOnce, now, 0}).first;
    Bucket& bucket = found->second;
    const double passed = std::chrono::duration<double>(now - bucket.at).count();
    bucket.lines = std::min(kAtOnce, bucket.lines + kEachSecond * passed);
    bucket.at = now;
    if (bucket.lines < 1.0) {
      ++bucket.omitted;
      return std::nullopt;
    }
    bucket.lines -= 1.0;
    return std::exchange(bucket.omitted, 0);
  }

 private:
  struct Bucket {
    double lines;
    Time at;
    std::uint64_t omitted;
  };
  std::map<std::string, Bucket, std::less<>> buckets_;  // of events: literals of the program
};

}  // namespace hecaton::services
