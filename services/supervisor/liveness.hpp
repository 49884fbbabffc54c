#pragma once
/// Who is alive, judged by how long each has been silent. Standard library only: time is an argument.
///
/// Silence is measured in *punctual* time: time in which the judge's own loop ran as it should. Who was itself stalled
/// knows nothing of the others for that time and does not accuse them of it.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace hecaton::services {

using Time = std::chrono::nanoseconds;  ///< since any fixed instant; never goes back

/// Counts the time in which its owner's loop was punctual.
class PunctualClock {
 public:
  /// An interval between two calls of advance() above `limit` is a stall, of which only `period` counts.
  PunctualClock(Time period, Time limit, Time now) : period_(period), limit_(limit), now_(now), before_(now) {}

  /// To be called once in each turn of the loop. True: the loop was stalled since the last call.
  bool advance(Time now);
  [[nodiscard]] Time now() const { return punctual_; }
  /// The latest punctual instant that `at` (≤ the last advance) can have been.
  [[nodiscard]] Time at(Time at) const;
  [[nodiscard]] Time stalled() const { return stalled_; }        ///< altogether
  [[nodiscard]] Time last_stall() const { return last_stall_; }  ///< how long the latest was
  [[nodiscard]] std::uint64_t stalls() const { return stalls_; }

 private:
  Time period_, limit_;
  Time now_, before_;  // the last two calls of advance()
  Time punctual_{0}, punctual_before_{0};
  Time stalled_{0}, last_stall_{0};
  std::uint64_t stalls_ = 0;
};

enum class Presence : std::uint8_t {
  kWaiting,    ///< not heard yet, within its grace
  kMissing,    ///< not heard yet, and its grace is over
  kAlive,      ///< heard within its limit
  kSuspected,  ///< silent longer than `silence`
  kLost,       ///< silent longer than `lost`
  kReturning,  ///< heard again, but not for long enough to rely on it
};

struct LivenessLimits {
  Time silence = std::chrono::milliseconds(20);    ///< > the period at which it is heard
  Time lost = std::chrono::milliseconds(100);      ///< ≥ silence
  Time grace = std::chrono::seconds(10);           ///< to appear after expect() or restarted()
  Time recovery = std::chrono::milliseconds(100);  ///< heard without a gap this long, it is alive again
};

class Liveness {
 public:
  explicit Liveness(const PunctualClock& clock) : clock_(clock) {}

  /// Begins to watch `name`, whose grace starts now.
  void expect(const std::string& name, const LivenessLimits& limits);
  /// A new process took its place: it has a new grace, and must prove itself before it is alive.
  void restarted(std::string_view name);
  /// A sign of life that arrived at `at` (≤ the clock's last advance).
  void heard(std::string_view name, Time at);
  /// Silence of up to this is nothing that it does, whatever its limits are.
  void allow(std::string_view name, Time silence);
  /// After a turn's signs of life are in: what each is now. `stalled`: what the clock said of this turn.
  void judge(bool stalled);

  [[nodiscard]] bool knows(std::string_view name) const { return find(name) != nullptr; }
  [[nodiscard]] Presence presence(std::string_view name) const;
  /// Punctual time since the last sign of life, or since its grace began.
  [[nodiscard]] Time silence(std::string_view name) const;
  /// Silent for longer it is suspected, or lost: its limits, or what it was allowed.
  [[nodiscard]] LivenessLimits limits(std::string_view name) const;
  /// Punctual time of the last sign of life; empty: none since expect() or restarted().
  [[nodiscard]] std::optional<Time> last_heard(std::string_view name) const;
  /// Punctual time since which its signs of life have come without a gap; empty likewise.
  [[nodiscard]] std::optional<Time> steady_since(std::string_view name) const;

 private:
  struct Entry {
    LivenessLimits limits;
    Time allowed{0};  // silence, whatever the limits are
    Presence presence = Presence::kWaiting;
    bool heard = false;
    bool must_prove = false;       // alive only after `recovery`
    Time since{0};                 // of the grace
    Time last{0};                  // sign of life
    Time steady_since{0};          // signs of life without a gap
    std::optional<Time> pardoned;  // until when a stall of ours lets it be silent
  };
  [[nodiscard]] const Entry* find(std::string_view name) const;
  [[nodiscard]] static LivenessLimits limits(const Entry& entry);
  [[nodiscard]] Time silence(const Entry& entry) const;
  [[nodiscard]] Presence judged(Entry& entry) const;

  const PunctualClock& clock_;
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace hecaton::services
