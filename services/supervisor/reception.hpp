#pragma once
/// How much of what hosts send is lost on its way to us, and so how many heartbeats of a node may be missing in a row
/// without its doing (docs/design/0003-supervision.md, 14). Standard library only; all time is punctual.

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>

#include "services/supervisor/liveness.hpp"

namespace hecaton::services {

class Reception {
 public:
  /// A row of losses that is rarer than this is none: once in a day where 1000 heartbeats come in a second.
  static constexpr double kRare = 1e-8;
  /// Where more is lost no cell can work.
  static constexpr double kMostLost = 0.4;

  /// Heartbeats that should be here by now: one or two each of nodes that may be well.
  struct Late {
    int host = 0;  ///< of nodes of the host
    int all = 0;   ///< of all nodes
  };

  /// `own`: our host; nothing of it is lost.
  Reception(const PunctualClock& clock, std::string own) : clock_(clock), own_(std::move(own)) {}

  /// What comes from this sender tells of the way from its host. Senders have any names that differ.
  void expect(const std::string& sender, const std::string& host);
  /// Sample `number` of it. Each process, known by any number that is its own, counts them from 1; 0: not counted.
  void arrived(std::string_view sender, std::int64_t process, std::uint64_t number);
  /// The share of the host's samples that is lost, in [0, kMostLost]: of its own or of all hosts', in the last tenth of
  /// a second or the last second, whichever is the most. What is late counts as lost.
  [[nodiscard]] double lost(std::string_view host, const Late& late) const;
  /// So many in a row may be lost where this share is: the smallest k with lost^k ≤ kRare.
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
    Tally lately{std::chrono::milliseconds(100)};  // or its onset would be seen too late
    Tally before{std::chrono::seconds(1)};         // or a few in a hundred would not be seen
    void count(Time now, double lost);
    [[nodiscard]] double share_lost(Time now, int late) const;
  };
  struct Sender {
    Way* way = nullptr;  // from its host; null: it is ours
    std::int64_t process = 0;
    std::uint64_t number = 0;  // of the last that arrived
  };

  const PunctualClock& clock_;
  std::string own_;
  Way all_;
  std::map<std::string, Way, std::less<>> hosts_;
  std::map<std::string, Sender, std::less<>> senders_;
};

}  // namespace hecaton::services
