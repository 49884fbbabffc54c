#pragma once
/// Which senders are alive, judged by how long each has been silent. Standard library only; all times are those of one
/// StallCompensatedClock.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

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
  explicit Liveness(const StallCompensatedClock& clock) : clock_(clock) {}

  /// Begins to watch `name`. Its grace starts now.
  void expect(const std::string& name, const LivenessLimits& limits);
  /// A new process took its place: it has a new grace, and must prove itself before it is alive.
  void restarted(std::string_view name);
  /// A sign of life that arrived at `at` (≤ the clock's last advance).
  void heard(std::string_view name, Time at);
  /// Silence of up to this is explained by lost packets, whatever its limits are.
  void allow(std::string_view name, Time silence);
  /// Call it once in each turn, after its signs of life. `stalled`: what the clock said of this turn. After a stall
  /// each sender that is not suspected yet gets one fresh allowance, at most every second one, so that stalls in a row
  /// delay the discovery of a hang but cannot hide it.
  void judge(bool stalled);

  [[nodiscard]] bool knows(std::string_view name) const { return find(name) != nullptr; }
  [[nodiscard]] Presence presence(std::string_view name) const;
  /// Since the last sign of life, or since its grace began.
  [[nodiscard]] Time silence(std::string_view name) const;
  /// Its limits, raised to what it was allowed.
  [[nodiscard]] LivenessLimits limits(std::string_view name) const;
  /// Time of the last sign of life; empty: none since expect() or restarted().
  [[nodiscard]] std::optional<Time> last_heard(std::string_view name) const;
  /// Since when its signs of life have come without a gap; empty likewise.
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
    std::optional<Time> pardoned;  // until when a stall of the observer lets it be silent
  };
  [[nodiscard]] const Entry* find(std::string_view name) const;
  [[nodiscard]] static LivenessLimits limits(const Entry& entry);
  [[nodiscard]] Time silence(const Entry& entry) const;
  [[nodiscard]] Presence judged(Entry& entry) const;

  const StallCompensatedClock& clock_;
  std::map<std::string, Entry, std::less<>> entries_;
};

}  // namespace hecaton::services
