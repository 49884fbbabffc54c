#pragma once
/// Counts what a recording does not have. Standard library and idl values only.

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/raw_reader.hpp"

namespace hecaton::services::recorder {

/// Of one topic, since the recording began.
struct TopicLosses {
  std::uint64_t received = 0;    ///< samples that passed all checks
  std::uint64_t missing = 0;     ///< gaps in the field sequence_number of a best-effort topic
  std::uint64_t lost = 0;        ///< reported by the middleware; counts a gap once more
  std::uint64_t overflowed = 0;  ///< dropped because the disk was too slow
  std::uint64_t refused = 0;     ///< samples that break a rule of the wire, or of a second writer

  [[nodiscard]] bool any() const { return missing > 0 || lost > 0 || overflowed > 0 || refused > 0; }
  bool operator==(const TopicLosses&) const = default;

  /// By the names that reports have.
  [[nodiscard]] std::map<std::string, std::uint64_t> fields() const {
    return {
        {"received", received}, {"missing", missing}, {"lost", lost}, {"overflowed", overflowed}, {"refused", refused}};
  }
  /// For people: "2 missing, 3 lost by the network, …".
  [[nodiscard]] std::string text() const {
    return std::to_string(missing) + " missing, " + std::to_string(lost) + " lost by the network, " +
           std::to_string(overflowed) + " dropped by a slow disk, " + std::to_string(refused) + " refused";
  }
};

/// For one thread.
class LossCounter {
 public:
  /// A sample was taken out of the readers. Samples of one writer come in their order.
  void note(const bus::RawSample& sample) {
    const bool best_effort = !bus::kTopics[sample.topic].qos.reliable;
    if (!best_effort || !sample.sequence_number) return;
    const auto [last, first] = last_.try_emplace({sample.topic, sample.writer}, *sample.sequence_number);
    if (first) return;
    if (*sample.sequence_number > last->second) missing_[sample.topic] += *sample.sequence_number - last->second - 1;
    last->second = *sample.sequence_number;
  }

  /// One for each topic of bus::kTopics.
  [[nodiscard]] std::vector<TopicLosses> losses(const std::vector<bus::RawCounters>& counters) const {
    std::vector<TopicLosses> all;
    for (std::size_t i = 0; i < counters.size(); ++i) {
      const bus::RawCounters& raw = counters[i];
      all.push_back({raw.received, missing_[i], raw.lost, raw.overflowed, raw.refused});
    }
    return all;
  }

 private:
  std::map<std::pair<std::size_t, bus::EndpointId>, std::uint64_t> last_;  ///< sequence number
  std::array<std::uint64_t, bus::kTopics.size()> missing_{};
};

}  // namespace hecaton::services::recorder
