#pragma once
/// Liveness of senders, judged by their silence, and the share of packets that the network loses, which tells how long
/// a silence chance explains (docs/explanation/0003-fault-detection.md). Standard library only; all times are those of
/// one StallCompensatedClock.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

enum class Presence : std::uint8_t {
  kWaiting,    ///< not heard yet, within its grace
  kMissing,    ///< not heard within its grace
  kAlive,      ///< heard within its limit
  kSuspected,  ///< silent for longer than `silence`
  kLost,       ///< silent for longer than `lost`
  kReturning,  ///< heard again, for less than `recovery`
};

struct LivenessLimits {
  Time silence = std::chrono::milliseconds(20);    ///< > the sender's period
  Time lost = std::chrono::milliseconds(100);      ///< ≥ silence
  Time grace = std::chrono::seconds(10);           ///< to appear after expect() or restarted()
  Time recovery = std::chrono::milliseconds(100);  ///< after a silence, heard for this without a gap, it is alive again
};

class Liveness {
 public:
  /// `clock` must outlive it.
  explicit Liveness(const StallCompensatedClock& clock) : clock_(clock) {}

  /// Begins to watch `name`. Its grace starts now. Other calls ignore names that are not expected.
  void expect(const std::string& name, const LivenessLimits& limits);
  /// A new process has taken its place: it has a new grace and is alive only after `recovery`.
  void restarted(std::string_view name);
  /// A packet arrived at `at` (≤ the clock's last advance).
  void heard(std::string_view name, Time at);
  /// Lost packets explain a silence of up to this, whatever the limits are.
  void allow(std::string_view name, Time silence);
  /// Call it once in each turn, after its packets. `stalled`: what the clock's advance() returned in this turn. After a
  /// stall each sender that is not suspected gets one fresh allowance, at most every second one: stalls in a row delay
  /// the detection of a hang but cannot prevent it.
  void judge(bool stalled);

  [[nodiscard]] bool knows(std::string_view name) const { return find(name) != nullptr; }
  [[nodiscard]] Presence presence(std::string_view name) const;
  /// Since the last packet, or since the grace began.
  [[nodiscard]] Time silence(std::string_view name) const;
  /// The limits, raised to the allowed silence.
  [[nodiscard]] LivenessLimits limits(std::string_view name) const;
  /// Arrival of the last packet; empty: none since expect() or restarted().
  [[nodiscard]] std::optional<Time> last_heard(std::string_view name) const;
  /// Since when packets have arrived without a gap; empty likewise.
  [[nodiscard]] std::optional<Time> steady_since(std::string_view name) const;

 private:
  struct Entry {
    LivenessLimits limits;
    Time allowed{0};  // silence that losses explain
    Presence presence = Presence::kWaiting;
    bool heard = false;
    bool must_recover = false;          // alive only after `recovery`
    Time since{0};                      // beginning of the grace
    Time last{0};                       // last packet
    Time steady_since{0};               // packets without a gap
    std::optional<Time> allowed_until;  // because of a stall of the observer
  };
  [[nodiscard]] const Entry* find(std::string_view name) const;
  [[nodiscard]] static LivenessLimits limits(const Entry& entry);
  [[nodiscard]] Time silence(const Entry& entry) const;
  [[nodiscard]] Presence judged(Entry& entry) const;

  const StallCompensatedClock& clock_;
  std::map<std::string, Entry, std::less<>> entries_;
};

/// Share of packets that the network loses on the path from each host, estimated from gaps in sequence numbers.
class PacketLossEstimator {
 public:
  /// More losses in a row than have this probability are not chance: once a day at 1000 heartbeats a second.
  static constexpr double kChanceLimit = 1e-8;
  /// Upper bound of the estimate: no cell works with more losses.
  static constexpr double kMaxLossRate = 0.4;

  /// Heartbeats that are overdue, one or two each of nodes that may be healthy.
  struct Overdue {
    int host = 0;  ///< of nodes of the host
    int all = 0;   ///< of all nodes
  };

  /// `own`: the observer's host, from which nothing is lost. `clock` must outlive it.
  PacketLossEstimator(const StallCompensatedClock& clock, std::string own) : clock_(clock), own_(std::move(own)) {}

  /// Samples of `sender` are evidence about the path from `host`. Names of senders are unique.
  void expect(const std::string& sender, const std::string& host);
  /// Sample `number` arrived. Each process (any number that identifies it) counts its samples from 1; 0: not counted.
  void arrived(std::string_view sender, std::int64_t process, std::uint64_t number);
  /// Share of the host's samples that is lost, in [0, kMaxLossRate]: the largest of the shares of this host and of all
  /// hosts, in the last tenth of a second and in the last second. Overdue heartbeats count as lost.
  [[nodiscard]] double lost(std::string_view host, const Overdue& overdue) const;
  /// Number of losses in a row that chance explains: the smallest k with lost^k ≤ kChanceLimit.
  [[nodiscard]] static int longest_gap(double lost);

 private:
  /// Counts of received and lost samples that decay exponentially.
  class DecayingCount {
   public:
    explicit DecayingCount(Time time_constant) : time_constant_(time_constant) {}
    void count(Time now, double lost);
    [[nodiscard]] double loss_rate(Time now, int overdue) const;

   private:
    [[nodiscard]] double remaining(Time now) const;  // share of the counts
    Time time_constant_;
    Time at_{0};
    double received_ = 0.0;
    double lost_ = 0.0;
  };
  struct Path {
    DecayingCount fast{std::chrono::milliseconds(100)};  // shows an onset soon
    DecayingCount slow{std::chrono::seconds(1)};         // shows a loss of a few per cent
    void count(Time now, double lost);
    [[nodiscard]] double loss_rate(Time now, int overdue) const;
  };
  struct Sender {
    Path* path = nullptr;  // from its host; null: the observer's own
    std::int64_t process = 0;
    std::uint64_t number = 0;  // of the last sample that arrived
  };

  const StallCompensatedClock& clock_;
  std::string own_;
  Path all_;
  std::map<std::string, Path, std::less<>> hosts_;
  std::map<std::string, Sender, std::less<>> senders_;
};

}  // namespace hecaton::services
