#pragma once
/// The hosts of a cell and the links between them, judged on the reachability matrix (docs/design/0003-supervision.md).
/// Standard library only; all times are those of the observer's StallCompensatedClock.
///
/// One turn: everything that arrived (heard, row), then judge().

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/supervisor/detection/reachability_matrix.hpp"

namespace hecaton::services {

struct HostLimits {
  Time lease = std::chrono::milliseconds(100);         ///< silence of a host that is a fault
  Time link_deadline = std::chrono::milliseconds(60);  ///< < lease: a host hears another within this
  Time recent_row = std::chrono::milliseconds(25);     ///< rows that tell whether this host is heard are younger
  Time pause = std::chrono::milliseconds(20);          ///< a host that was silent for this has to return
  Time settling = std::chrono::milliseconds(60);       ///< after its return, before its processes are compared
  Time recovery = std::chrono::milliseconds(100);      ///< hearing in both directions that proves a return
  /// Within this the middleware finds all processes of a host again that was away for a lease.
  Time rediscovery = std::chrono::seconds(5);
  /// A process that was heard for this without a gap after such an absence was found for good.
  Time sure_return = std::chrono::seconds(1);
};

enum class HostState {
  kHeard,     ///< or never heard yet
  kLost,      ///< no host hears it
  kIsolated,  ///< it hears no other host, or, of the observer's host, no other host hears it
};

class HostMonitor {
 public:
  /// A link between two hosts; `observer` does not hear `subject`.
  struct Link {
    HostIndex subject = 0;
    HostIndex observer = 0;
    Time since{0};  ///< evidence without a gap
  };

  /// `own`: the observer's host; one that is not in `hosts`: the observer belongs to no host of the cell. `clock` must
  /// outlive it.
  HostMonitor(std::vector<std::string> hosts, const std::string& own, const HostLimits& limits,
              const StallCompensatedClock& clock);

  [[nodiscard]] std::optional<HostIndex> index(std::string_view host) const { return matrix_.index(host); }
  [[nodiscard]] const std::string& name(HostIndex host) const { return matrix_.name(host); }
  [[nodiscard]] std::optional<HostIndex> own() const { return own_; }

  /// A packet of any process of `host` arrived at `at`. Hosts are judged from when `from_agent` was true once.
  void heard(HostIndex host, Time at, bool from_agent);
  /// The row that the agent of `host` sent.
  void row(HostIndex host, const std::vector<HostAge>& ages, Time at);
  /// Silence of up to this is explained by lost packets.
  void allow(HostIndex host, Time silence) { hosts_[host].allowed = silence; }
  /// `stall`: how long the observer's loop stood still before this turn; 0: it was punctual.
  void judge(Time stall);

  [[nodiscard]] HostState state(HostIndex host) const { return hosts_[host].state; }
  /// The observer's own host hears no other host, or no other host hears it.
  [[nodiscard]] bool isolated() const { return own_ && hosts_[*own_].state == HostState::kIsolated; }
  /// Links of which the loss is proven, one a pair of hosts.
  [[nodiscard]] std::vector<Link> lost_links() const;
  /// Empty: never heard.
  [[nodiscard]] std::optional<Time> silence(HostIndex host) const;
  [[nodiscard]] bool judged(HostIndex host) const { return hosts_[host].has_agent; }
  /// The link between the observer's host and this one is lost, in either direction.
  [[nodiscard]] bool link_is_lost(HostIndex host) const;
  /// When the packets of `host` returned after the last pause.
  [[nodiscard]] Time returned(HostIndex host) const { return hosts_[host].returned; }
  /// When `host` was last away for a lease, or the observer was; empty: not within the time of rediscovery.
  [[nodiscard]] std::optional<Time> away(HostIndex host) const;
  /// More than half of the hosts that are judged are heard within `limit`.
  [[nodiscard]] bool hears_most(Time limit) const;

 private:
  struct Host {
    bool has_agent = false;
    std::optional<Time> heard{};
    Time returned{0};      // end of the last pause in what the observer hears
    Time steady_since{0};  // end of the last gap of a link deadline
    Time allowed{0};       // silence, because of losses
    std::optional<Time> away{};
    std::optional<Time> mutual_since{};   // hears the observer's host and is heard
    std::optional<Time> hearing_since{};  // hears any other host
    HostState state = HostState::kHeard;
  };
  struct Pair {
    Link link;
    bool proven = false;
    std::optional<Time> heard_since{};
  };
  void note_stall(Time stall);
  void note_directions();
  void judge_own();
  void judge_deaf(HostIndex host);
  void judge_silent(HostIndex host);
  void judge_links();
  void judge_link(HostIndex subject, HostIndex observer);
  void note_absences();

  [[nodiscard]] Time now() const { return clock_.now(); }
  [[nodiscard]] bool others(HostIndex host) const { return host != own_ && hosts_[host].has_agent; }
  [[nodiscard]] bool is_silent(HostIndex host) const;
  [[nodiscard]] bool is_live(HostIndex host) const;
  /// How long `observer` has not heard `subject`, where that proves something: the agent of `subject` sends, and
  /// `observer` has heard it since its last absence, or had the time to. Empty: it proves nothing.
  [[nodiscard]] std::optional<Time> unheard_for(HostIndex subject, HostIndex observer) const;
  [[nodiscard]] bool is_heard_by_others(HostIndex host, std::optional<HostIndex> but) const;
  /// A third host sends rows.
  [[nodiscard]] bool has_witness(HostIndex host) const;
  /// No other host is heard, and several fell silent together.
  [[nodiscard]] bool may_be_isolated() const;
  [[nodiscard]] bool is_rediscovering(HostIndex host) const;
  [[nodiscard]] bool settles() const;
  [[nodiscard]] bool is_not_heard(HostIndex subject, HostIndex observer) const;
  [[nodiscard]] bool hears_again(HostIndex subject, HostIndex observer) const;
  /// Those that fell silent within a lease of the last one, and how long that one has been silent.
  [[nodiscard]] std::pair<int, Time> silent_together() const;

  HostLimits limits_;
  const StallCompensatedClock& clock_;
  ReachabilityMatrix matrix_;
  std::optional<HostIndex> own_;
  std::vector<Host> hosts_;
  std::map<std::pair<HostIndex, HostIndex>, Pair> pairs_;  // by smaller and larger index
  std::optional<Time> unsettled_;                          // last, when the observer was isolated or stood still
  std::optional<Time> isolated_at_;                        // last, when that was proven
};

}  // namespace hecaton::services
