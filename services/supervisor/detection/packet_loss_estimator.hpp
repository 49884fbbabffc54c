#pragma once
/// The share of packets that is lost on the way from each host, and so how many heartbeats of a node may be missing in
/// a row by chance (docs/design/0003-supervision.md). Standard library only; all times are those of one
/// StallCompensatedClock.

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

class PacketLossEstimator {
 public:
  /// More losses in a row than this probability allows are no chance: once in a day at 1000 heartbeats a second.
  static constexpr double kRare = 1e-8;
  /// With more losses no cell works.
  static constexpr double kMostLost = 0.4;

  /// Heartbeats that are overdue: one or two each of nodes that may be well.
  struct Late {
    int host = 0;  ///< of nodes of the host
    int all = 0;   ///< of all nodes
  };

  /// `own`: the observer's host; nothing of it is lost. `clock` must outlive it.
  PacketLossEstimator(const StallCompensatedClock& clock, std::string own) : clock_(clock), own_(std::move(own)) {}

  /// Samples of this sender tell of the way from its host. Names of senders differ from each other.
  void expect(const std::string& sender, const std::string& host);
  /// Sample `number` of it arrived. Each process (any number that only it has) counts its samples from 1; 0: not
  /// counted.
  void arrived(std::string_view sender, std::int64_t process, std::uint64_t number);
  /// The share of the host's samples that is lost, in [0, kMostLost]: the largest of its own and of all hosts' share,
  /// in the last tenth of a second and in the last second. Overdue samples count as lost.
  [[nodiscard]] double lost(std::string_view host, const Late& late) const;
  /// So many in a row may be lost by chance: the smallest k with lost^k ≤ kRare.
  [[nodiscard]] static int longest_row(double lost);

 private:
  /// Counts that fade.
  class Tally {
   public:
    explicit Tally(Time fades) : fades_(fades) {}
    void count(Time now, double lost);
    [[nodiscard]] double share_lost(Time now, int late) const;

   private:
    [[nodiscard]] double left(Time now) const;  // of what was counted
    Time fades_;
    Time at_{0};
    double received_ = 0.0;
    double lost_ = 0.0;
  };
  struct Way {
    Tally lately{std::chrono::milliseconds(100)};  // shows an onset soon
    Tally before{std::chrono::seconds(1)};         // shows a loss of a few in a hundred
    void count(Time now, double lost);
    [[nodiscard]] double share_lost(Time now, int late) const;
  };
  struct Sender {
    Way* way = nullptr;  // from its host; null: the observer's own
    std::int64_t process = 0;
    std::uint64_t number = 0;  // of the last that arrived
  };

  const StallCompensatedClock& clock_;
  std::string own_;
  Way all_;
  std::map<std::string, Way, std::less<>> hosts_;
  std::map<std::string, Sender, std::less<>> senders_;
};

}  // namespace hecaton::services
