#pragma once
/// From signs of life, rows of reachability, process events and orders to the faults and the mode of a cell: the whole
/// judgement of the supervisor. Pure: time is an argument, and every fault can be tested without a
/// network.
///
/// One turn of the owner's loop: advance(now), everything that arrived, judge(now).
///
/// The principle is who hears whom (docs/design/0003-supervision.md). l is the supervisor's host, k another host:
///
///   situation                        row of k           rows of others about k   rule → fault
///   process of k killed              fresh              fresh                    1 PROCESS_DIED, told by the agent
///   process of k hangs               fresh              fresh                    1 NODE_SILENT
///   driver or world sends no states  fresh              fresh                    1 DRIVER_SILENT, WORLD_SILENT
///   link k → l lost                  fresh at others    fresh                    2 LINK_LOST
///   k without power, or cut          none               old                      3 HOST_LOST k
///   k sends nothing (mute)           none               old                      3 HOST_LOST k
///   k hears nothing (deaf)           fresh, all old     fresh                    4 HOST_ISOLATED k
///   l hears no host                  none               none                     5 HOST_ISOLATED l
///   l sends nothing (mute)           fresh, l old       l old                    5 HOST_ISOLATED l
///   cell of two hosts, k silent      none               –                        6 LINK_LOST
///   k returns                        fresh, l fresh     fresh                    7 over after 100 ms
///
/// A node that reports that it cannot work is NODE_FAILED; a device that reports a failure is ARM_FAILED.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "services/supervisor/cell_mode.hpp"
#include "services/supervisor/detection/detection_limits.hpp"
#include "services/supervisor/detection/host_monitor.hpp"
#include "services/supervisor/detection/liveness.hpp"
#include "services/supervisor/detection/packet_loss_estimator.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

struct Heartbeat {
  std::int64_t pid = 0;
  Time at{0};                           ///< when it arrived
  std::uint64_t number = 0;             ///< the process counts its heartbeats from 1; 0: unknown
  std::optional<msg::Cause> failure{};  ///< the node reports that it cannot do its work, and why; its text may be ""
};

struct ProcessExit {
  std::int64_t pid = 0;
  int exit_code = 0;
  int signal_number = 0;  ///< 0: it returned
  bool wanted = false;    ///< it was ordered to end
  /// When, if it was before this supervisor heard the agent, or was told late; otherwise just now.
  std::optional<Time> at{};
  msg::Cause cause{};  ///< why its agent ended it, unasked; CAUSE_NONE: it did not
};

/// "process 123 was ended by signal 9 (Killed)", "its agent ended process 123: its loop was silent for 10012 ms"
[[nodiscard]] std::string end_text(const ProcessExit& exit);

/// The key of a node's fault in the FaultList. Most kinds explain each other and share one key.
[[nodiscard]] std::string cause_of(msg::CauseKind kind, const std::string& node);
/// The key of a fault of this kind and subject.
[[nodiscard]] std::string cause_of_subject(msg::CauseKind kind, const std::string& subject);

/// Why nothing is heard of an arm's driver.
enum class Loss : std::uint8_t {
  kNone,       ///< it is heard, or may be heard again in a moment
  kEnded,      ///< its process has ended, as its agent says
  kHostSilent  ///< its host is lost, and this supervisor hears most hosts: no other side can conclude this of this one
};

class FaultDetector {
 public:
  /// `host`: the supervisor's; empty: none of the cell's.
  FaultDetector(std::vector<ExpectedNode> nodes, std::vector<std::string> arms, const DetectionLimits& limits, Time now,
                const std::string& host = {});
  FaultDetector(const FaultDetector&) = delete;
  FaultDetector& operator=(const FaultDetector&) = delete;

  void advance(Time now);
  /// Unknown nodes, hosts and arms are ignored, here and below.
  void heard(std::string_view node, const Heartbeat& heartbeat);
  /// ArmState from a driver, ObstacleStates from the world: signs of life of the loop, too. `number`: as in Heartbeat.
  void stream_heard(std::string_view node, Time at, std::uint64_t number = 0);
  /// The row of reachability from the agent of `host`, arrived at `at`.
  void row_heard(std::string_view host, const std::vector<HostAge>& ages, Time at);
  /// What the newest ArmState says of the arm's device. `failure`: it reports a failure, and why (may be ""); empty: it
  /// reports none.
  void device_heard(std::string_view arm, std::optional<std::string> failure);
  void process_started(std::string_view node, std::int64_t pid);
  /// `news`: it is a fault even when its successor is there before the next judgement. Otherwise the end may have been
  /// told before and matters only until a successor has taken its place.
  void process_exited(std::string_view node, const ProcessExit& exit, bool news = true);
  /// The contacts that the contact monitor has counted in all, and the latest of them. Those of before the first call
  /// count as told where a contact is remembered.
  void contacts(std::uint64_t count, const std::string& subject, const std::string& seen);
  /// A fault that another supervisor told while it led. It lasts as long as its cause does in this judgement; what this
  /// one does not judge (itself, a contact) is over.
  void adopt(const std::string& cause, const FaultRecord& record, Time now);
  /// Of an arm with a standby: only the faults of this planner hold the arm.
  void put_in_charge(const std::string& arm, const std::string& planner) { in_charge_[arm] = planner; }
  void judge(Time now);
  /// The next judge() judges once more what came and went since `since` and what the fault list does not have: of two
  /// supervisors the other may have been lost before it told.
  void judge_again(Time since);

  [[nodiscard]] FaultList& faults() { return faults_; }
  [[nodiscard]] const FaultList& faults() const { return faults_; }
  [[nodiscard]] CellModeState& mode() { return mode_; }
  [[nodiscard]] const CellModeState& mode() const { return mode_; }
  [[nodiscard]] const std::vector<ExpectedNode>& nodes() const { return nodes_; }

  [[nodiscard]] bool expects(std::string_view node) const { return find(node) != nullptr; }
  /// Heard, not for the first time after a fault, and its process is not known to be dead.
  [[nodiscard]] bool alive(std::string_view node) const;
  /// Its process has ended and no successor was heard of, or it never appeared.
  [[nodiscard]] bool ended(std::string_view node) const;
  /// Of its loop, in compensated time; empty: not heard yet.
  [[nodiscard]] std::optional<Time> silence(std::string_view node) const;
  /// The planner that commands the arm, or is to.
  [[nodiscard]] std::string in_charge(std::string_view arm) const;
  [[nodiscard]] Loss loss_of(std::string_view arm) const;
  /// The host of this node is heard and hears no other host.
  [[nodiscard]] bool is_isolated(std::string_view node) const;
  /// What a node is being waited for: "planner/arm1 has not appeared yet"; CAUSE_NONE when it is there.
  [[nodiscard]] msg::Cause awaited(std::string_view node) const;

 private:
  struct State {
    std::int64_t pid = 0;               // as last heard or started; 0: unknown
    std::optional<ProcessExit> died{};  // and nothing was heard of a successor
    bool stopped = false;               // was ordered to end, and did
    bool has_stream = false;
    std::optional<msg::Cause> failure{};          // of the node, in its own words
    std::optional<std::string> device_failure{};  // of a driver's device
    std::optional<ProcessExit> unjudged{};        // an end that no judgement has seen
    std::optional<Time> unjudged_since{};         // when that was, if it is judged once more
    Time silence_at_end{0};                       // when its last end was told
    std::optional<Time> back{};                   // it has returned from the absence of its host that ended then
    Time heartbeat_at{0};                         // the last, of whichever process
    std::int64_t former_pid = 0;                  // of the process that was heard before this one
    std::int64_t untold_pid = 0;                  // the same, and nobody has told that it ended; 0: none
    Time returned_at{0};                          // when that last changed
    int returns = 0;                              // of one of the two after the other, without a pause
  };
  /// An end, or a contact (no node), as it was judged.
  struct Passing {
    Time at{0};
    std::string node;
    ProcessExit exit;
    FaultSight contact;
  };
  using FaultKey = std::pair<std::uint64_t, std::uint64_t>;  // life and number
  struct Contacts {
    std::uint64_t count = 0;  // told so far
    bool known = false;       // the contact monitor was heard
    std::vector<FaultSight> untold;
  };

  [[nodiscard]] const ExpectedNode* expected(std::string_view node) const;
  [[nodiscard]] const ExpectedNode* agent_of(std::string_view host) const;
  [[nodiscard]] const State* find(std::string_view node) const;
  void note_process(State& state, std::int64_t pid) const;
  void note_passing(Passing passing);

  void allow_for_losses();
  [[nodiscard]] int overdue_heartbeats(const ExpectedNode& node) const;

  void note_returns();
  void raise(const std::string& cause, const FaultSight& sight, Time now);
  void judge_nodes(Time now);
  void judge_hosts(Time now);
  void judge_links(Time now);
  void judge_duplicates(Time now);
  void judge_devices(Time now);
  void judge_contacts(Time now);
  void hold_until_resumed();
  [[nodiscard]] bool sound(const ExpectedNode& node) const;
  [[nodiscard]] std::optional<FaultSight> sight(const ExpectedNode& node) const;
  [[nodiscard]] std::optional<FaultSight> silence_sight(const ExpectedNode& node, Presence presence) const;
  [[nodiscard]] std::optional<FaultSight> stream_sight(const ExpectedNode& node) const;
  [[nodiscard]] FaultSight host_sight(HostIndex host) const;
  [[nodiscard]] bool falls_behind(const ExpectedNode& node, Time limit) const;
  [[nodiscard]] bool is_excused(const ExpectedNode& node) const;
  [[nodiscard]] bool returns(const ExpectedNode& node) const;

  [[nodiscard]] AutomaticHolds holds() const;
  [[nodiscard]] const FaultRecord* fault_holding(const ExpectedNode& node) const;
  /// Why the node holds its arm, or the world the cell; empty: it does not.
  [[nodiscard]] std::optional<msg::Cause> hold_cause(const ExpectedNode& node) const;
  [[nodiscard]] bool holds_arms(const ExpectedNode& node) const;

  DetectionLimits limits_;
  std::vector<ExpectedNode> nodes_;
  std::map<std::string, State, std::less<>> states_;
  StallCompensatedClock clock_;
  Liveness liveness_;
  HostMonitor hosts_;
  PacketLossEstimator losses_;
  std::map<std::string, std::string, std::less<>> in_charge_;  // arm → planner, where there are several
  FaultList faults_;
  CellModeState mode_;
  Contacts contacts_;
  std::deque<Passing> passing_;                         // newest last
  std::set<FaultKey> raised_;                           // here, not adopted; open
  std::set<std::pair<FaultKey, std::string>> ordered_;  // to hold until resumed: which fault, which arm; "": the cell
  bool stalled_ = false;                                // before this turn
};

}  // namespace hecaton::services
