#pragma once
/// The hosts of a cell and the links between them, judged by which host hears which
/// (docs/explanation/0003-fault-detection.md). Standard library only; all times are those of the supervisor's
/// StallCompensatedClock.

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

using HostIndex = std::size_t;

struct HostAge {
  std::string host;
  Time age{0};  ///< of the newest packet from it, when the row was sent
};

/// Which host hears which. The agent of each host sends a row: for every other host, the age of the newest packet from
/// it on the agent's clock. The matrix adds to each age the age of the row itself at the supervisor.
///
///                 subject   north  west  east
///   row of north              –     8     9      [ms]     north hears west and east
///   row of west               7     –   900               west does not hear east
///   row of east               6    11     –               east hears both: the link from east to west is lost
class ReachabilityMatrix {
 public:
  /// `link_deadline`: a host hears another if it had a packet within this; a row counts for as long. `absence` >
  /// link_deadline: without rows for this long, discovery has to match the agent with its peers again.
  ReachabilityMatrix(std::vector<std::string> hosts, Time link_deadline, Time absence);

  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] const std::string& name(HostIndex host) const { return rows_[host].host; }
  [[nodiscard]] std::optional<HostIndex> index(std::string_view host) const;  ///< empty: not a host of the cell

  /// The row of `observer` arrived at `at`. Unknown hosts in it are ignored.
  void update(HostIndex observer, const std::vector<HostAge>& ages, Time at);

  /// Arrival of the newest row; empty: none arrived.
  [[nodiscard]] std::optional<Time> arrival(HostIndex observer) const { return rows_[observer].at; }
  /// The newest row is younger than the link deadline.
  [[nodiscard]] bool fresh(HostIndex observer, Time now) const;
  /// When rows of `observer` returned after its last absence; 0 before the first.
  [[nodiscard]] Time returned(HostIndex observer) const { return rows_[observer].returned; }
  /// Rows have arrived without a gap for at least the link deadline.
  [[nodiscard]] bool steady(HostIndex observer, Time now) const;
  /// For how long `observer` has not heard `subject`. Empty: it has no fresh row, or has not heard `subject` since its
  /// last absence.
  [[nodiscard]] std::optional<Time> age(HostIndex observer, HostIndex subject, Time now) const;
  [[nodiscard]] bool hears(HostIndex observer, HostIndex subject, Time now) const;

 private:
  struct Row {
    std::string host;
    std::optional<Time> at{};  // arrival
    Time steady_since{0};
    Time returned{0};
    std::vector<std::optional<Time>> ages{};  // by subject
    std::vector<bool> found{};                // by subject: heard since `returned`
  };
  std::vector<Row> rows_;
  Time link_deadline_, absence_;
};

struct HostLimits {
  Time lease = std::chrono::milliseconds(100);         ///< silence of a host that is a fault
  Time link_deadline = std::chrono::milliseconds(60);  ///< < lease: a host hears another within this
  Time recent_row = std::chrono::milliseconds(25);     ///< age of rows that count as evidence about the own host
  Time pause = std::chrono::milliseconds(20);          ///< silence after which a host has to return
  Time settling = std::chrono::milliseconds(60);       ///< after a return, before processes of the host are compared
  Time recovery = std::chrono::milliseconds(100);      ///< hearing in both directions that proves a return
  /// Upper bound of the time in which discovery matches all processes of a host that was away for a lease.
  Time rediscovery = std::chrono::seconds(5);
  /// A process heard for this without a gap after such an absence is matched for good.
  Time sure_return = std::chrono::seconds(1);
};

enum class HostState {
  kHeard,     ///< or not heard yet
  kLost,      ///< no host hears it
  kIsolated,  ///< it hears no other host, or, of the supervisor's host, no other host hears it
};

/// One turn: everything that arrived (heard, row), then judge().
class HostMonitor {
 public:
  /// A direction of a link in which `observer` does not hear `subject`.
  struct Link {
    HostIndex subject = 0;
    HostIndex observer = 0;
    Time since{0};  ///< the evidence has no gap since then
  };

  /// `own`: the supervisor's host; a name that is not in `hosts`: none of the cell's. `clock` must outlive the monitor.
  HostMonitor(std::vector<std::string> hosts, const std::string& own, const HostLimits& limits,
              const StallCompensatedClock& clock);

  [[nodiscard]] std::optional<HostIndex> index(std::string_view host) const { return matrix_.index(host); }
  [[nodiscard]] const std::string& name(HostIndex host) const { return matrix_.name(host); }
  [[nodiscard]] std::optional<HostIndex> own() const { return own_; }

  /// A packet of any process of `host` arrived at `at`. A host is judged after the first packet `from_agent`.
  void heard(HostIndex host, Time at, bool from_agent);
  /// A row of the agent of `host` arrived at `at`.
  void row(HostIndex host, const std::vector<HostAge>& ages, Time at);
  /// Lost packets explain a silence of up to this.
  void allow(HostIndex host, Time silence) { hosts_[host].allowed = silence; }
  /// `stall`: how long the supervisor's loop stood still before this turn; 0: it was punctual.
  void judge(Time stall);

  [[nodiscard]] HostState state(HostIndex host) const { return hosts_[host].state; }
  /// The supervisor's own host is isolated.
  [[nodiscard]] bool isolated() const { return own_ && hosts_[*own_].state == HostState::kIsolated; }
  /// Links whose loss is proven, one for each pair of hosts.
  [[nodiscard]] std::vector<Link> lost_links() const;
  /// Empty: never heard.
  [[nodiscard]] std::optional<Time> silence(HostIndex host) const;
  [[nodiscard]] bool judged(HostIndex host) const { return hosts_[host].has_agent; }
  /// The link between the supervisor's host and this one is lost in some direction.
  [[nodiscard]] bool link_is_lost(HostIndex host) const;
  /// When packets of `host` returned after the last pause.
  [[nodiscard]] Time returned(HostIndex host) const { return hosts_[host].returned; }
  /// End of the last absence of `host`, or of the supervisor; empty: longer ago than rediscovery takes.
  [[nodiscard]] std::optional<Time> away(HostIndex host) const;
  /// More than half of the judged hosts are heard within `limit`.
  [[nodiscard]] bool hears_most(Time limit) const;

 private:
  struct Host {
    bool has_agent = false;
    std::optional<Time> heard{};  // last packet
    Time returned{0};             // end of the last pause
    Time steady_since{0};         // end of the last gap of a link deadline
    Time allowed{0};              // silence that losses explain
    std::optional<Time> away{};
    std::optional<Time> mutual_since{};   // it hears the supervisor's host and is heard
    std::optional<Time> hearing_since{};  // it hears any other host
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
  [[nodiscard]] bool is_other(HostIndex host) const { return host != own_ && hosts_[host].has_agent; }
  [[nodiscard]] bool is_silent(HostIndex host) const;
  [[nodiscard]] bool is_live(HostIndex host) const;
  /// For how long `observer` has not heard `subject`, if that is evidence: the agent of `subject` sends, and `observer`
  /// has heard it since its last absence, or had the time to. Empty: no evidence.
  [[nodiscard]] std::optional<Time> unheard_for(HostIndex subject, HostIndex observer) const;
  [[nodiscard]] bool is_heard_by_others(HostIndex host, std::optional<HostIndex> except) const;
  /// A third host sends rows.
  [[nodiscard]] bool has_witness(HostIndex host) const;
  /// No other host is heard, and several fell silent together.
  [[nodiscard]] bool may_be_isolated() const;
  [[nodiscard]] bool is_rediscovering(HostIndex host) const;
  /// The supervisor was isolated or stood still a moment ago: nothing is concluded yet.
  [[nodiscard]] bool settles() const;
  [[nodiscard]] bool is_not_heard(HostIndex subject, HostIndex observer) const;
  [[nodiscard]] bool hears_again(HostIndex subject, HostIndex observer) const;
  /// Number of other hosts that fell silent within a lease of the last one, and the silence of that one.
  [[nodiscard]] std::pair<int, Time> silent_together() const;

  HostLimits limits_;
  const StallCompensatedClock& clock_;
  ReachabilityMatrix matrix_;
  std::optional<HostIndex> own_;
  std::vector<Host> hosts_;
  std::map<std::pair<HostIndex, HostIndex>, Pair> pairs_;  // by smaller and larger index
  std::optional<Time> unsettled_;                          // last time that the supervisor was isolated or stood still
  std::optional<Time> isolated_at_;                        // last time that its isolation was proven
};

}  // namespace hecaton::services
