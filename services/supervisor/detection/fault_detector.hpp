#pragma once
/// From heartbeats, states, rows of reachability, process events and orders to the faults and the mode of a cell.
/// Pure: time is an argument.
///
/// One turn of the owner's loop: advance(now), everything that arrived, judge(now).
///
/// The detector concludes from which host hears which (docs/explanation/0003-fault-detection.md). l is the supervisor's
/// host, k another host:
///
///     situation                        row of k           rows of others about k   rule → fault
///     process of k killed              fresh              fresh                    1 PROCESS_DIED, reported by the
///     agent process of k hangs               fresh              fresh                    1 NODE_SILENT driver or world
///     sends no states  fresh              fresh                    1 DRIVER_SILENT, WORLD_SILENT link k → l lost fresh
///     at others    fresh                    2 LINK_LOST k without power, or cut          none               old 3
///     HOST_LOST k k sends nothing (mute)           none               old                      3 HOST_LOST k k hears
///     nothing (deaf)           fresh, all old     fresh                    4 HOST_ISOLATED k l hears no host none none
///     5 HOST_ISOLATED l l sends nothing (mute)           fresh, l old       l old                    5 HOST_ISOLATED l
///     cell of two hosts, k silent      none               –                        6 LINK_LOST
///     k returns                        fresh, l fresh     fresh                    7 cleared after 100 ms
///
/// Keys of a host that expire within kExpiryLead are CERTIFICATE_EXPIRES, which holds no arm.
/// A node that reports that it cannot work is NODE_FAILED. What the device of an arm reports is a fault of that kind.

#include <chrono>
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
#include "services/supervisor/detection/host_monitor.hpp"
#include "services/supervisor/detection/liveness.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

/// A node that the cell file places on a host.
struct ExpectedNode {
  std::string name;
  msg::NodeKind role{};
  std::string arm;  ///< of planners and drivers
  std::string host;
};

struct DetectionLimits {
  Time loop_period = std::chrono::milliseconds(5);  ///< of the supervisor's loop
  Time loop_limit = std::chrono::milliseconds(12);  ///< a longer interval is a stall of the supervisor
  Time heartbeat_period = std::chrono::milliseconds(10);
  LivenessLimits node;                               ///< of heartbeats
  Time host_lease = std::chrono::milliseconds(100);  ///< silence of a host, and of its agent
  /// Upper bound of the time in which discovery finds all nodes of a returning host (services/bus/rediscovery.hpp).
  Time rediscovery = std::chrono::seconds(5);
  Time sure_return = std::chrono::seconds(1);         ///< a node heard for this without a gap has returned for good
  Time arm_stream = std::chrono::milliseconds(20);    ///< silence of ArmState while the driver sends heartbeats
  Time world_stream = std::chrono::milliseconds(50);  ///< silence of ObstacleStates while the world sends heartbeats
  Time arm_period = std::chrono::milliseconds(4);     ///< of ArmState
  Time world_period = std::chrono::milliseconds(10);  ///< of ObstacleStates
  std::set<msg::CauseKind> waits_for_resume{};        ///< kinds of faults that hold until a person resumes

  [[nodiscard]] HostLimits hosts() const;
  /// Faults of this kind hold until a person resumes. CAUSE_HOST_ISOLATED and CAUSE_LINK_LOST do as CAUSE_HOST_LOST.
  [[nodiscard]] bool waits(msg::CauseKind kind) const;
};

/// When the first key of a node expires.
struct KeyExpiry {
  std::chrono::system_clock::time_point at;
  Time left{0};  ///< until then, on the supervisor's wall clock when it received the heartbeat; negative: has expired
};

struct Heartbeat {
  std::int64_t pid = 0;
  Time at{0};                           ///< of its arrival
  std::uint64_t number = 0;             ///< sequence number of the process, from 1; 0: unknown
  std::optional<msg::Cause> failure{};  ///< the node reports that it cannot work, and why; the text may be empty
  std::optional<KeyExpiry> keys{};      ///< empty: the node has none
  bool speaks = true;                   ///< its participant speaks for the node; else `failure` and `keys` do not count
};

struct ProcessExit {
  std::int64_t pid = 0;
  int exit_code = 0;
  int signal_number = 0;  ///< 0: it returned
  bool wanted = false;    ///< it was ordered to end
  /// Time of the exit, if it was before the supervisor heard the agent or if the event came late. Empty: just now.
  std::optional<Time> at{};
  msg::Cause cause{};  ///< why the agent killed it; CAUSE_NONE: it did not
};

/// "process 123 was ended by signal 9 (Killed)", "its agent ended process 123: its loop was silent for 10012 ms"
[[nodiscard]] std::string end_text(const ProcessExit& exit);

/// Why the supervisor does not hear an arm's driver.
enum class DriverLoss : std::uint8_t {
  kNone,       ///< it hears the driver, or may hear it again in a moment
  kEnded,      ///< the agent reports that the process has ended
  kHostSilent  ///< the host is lost, and this supervisor hears most hosts: no other side of a partition can say so
};

class FaultDetector {
 public:
  /// `host`: of the supervisor; empty: none of the cell's hosts.
  FaultDetector(std::vector<ExpectedNode> nodes, std::vector<std::string> arms, const DetectionLimits& limits, Time now,
                const std::string& host = {});
  FaultDetector(const FaultDetector&) = delete;
  FaultDetector& operator=(const FaultDetector&) = delete;

  // Inputs. Unknown nodes, hosts and arms are ignored, but for failures and unexpected ends of helpers.

  void advance(Time now);
  void heard(std::string_view node, const Heartbeat& heartbeat);
  /// ArmState from a driver or ObstacleStates from the world; it also counts as a heartbeat of the loop. `number`: as
  /// in Heartbeat.
  void stream_heard(std::string_view node, Time at, std::uint64_t number = 0);
  /// A row of reachability from the agent of `host`, which arrived at `at`.
  void row_heard(std::string_view host, const std::vector<HostAge>& ages, Time at);
  /// What the newest ArmState says of the arm's device. `fault`: one of kDeviceFaults, and why; empty: it works.
  void device_heard(std::string_view arm, std::optional<msg::Cause> fault);
  /// A node reports in its heartbeat what it refuses of a sender, see msg::Refusal.
  void refusal_heard(const std::string& node, const msg::Refusal& refusal);
  /// Nothing holds an arm that should move, and it stands (StandingArms). `why`: a sentence; empty: no longer.
  void arm_stands(const std::string& arm, const std::optional<std::string>& why);
  void process_started(std::string_view node, std::int64_t pid);
  /// `news`: true: the exit is a fault even if a successor runs before the next judgement. False: another supervisor
  /// may have published it, and it matters only until a successor runs.
  void process_exited(std::string_view node, const ProcessExit& exit, bool news = true);
  /// Number of contacts that the contact monitor has counted, and the newest of them. Contacts before the first call
  /// count as published if the fault list has one.
  void contacts(std::uint64_t count, const std::string& subject, const std::string& description);
  /// A fault that another supervisor published while it led. It is cleared when this detector no longer observes its
  /// cause, and at once if the detector does not judge its kind (the supervisor's own node, a contact).
  void adopt(const std::string& key, const FaultRecord& record, Time now);
  /// Of an arm with a standby planner: faults of this planner hold the arm, faults of the other do not.
  void put_in_charge(const std::string& arm, const std::string& planner) { in_charge_[arm] = planner; }

  /// Updates faults() and mode().
  void judge(Time now);
  /// The next judge() judges again exits and contacts since `since` that the fault list does not have, because the
  /// previous leader may have been lost before it published them.
  void judge_again(Time since);

  [[nodiscard]] FaultList& faults() { return faults_; }
  [[nodiscard]] const FaultList& faults() const { return faults_; }
  [[nodiscard]] CellModeState& mode() { return mode_; }
  [[nodiscard]] const CellModeState& mode() const { return mode_; }
  [[nodiscard]] const std::vector<ExpectedNode>& nodes() const { return nodes_; }

  [[nodiscard]] bool expects(std::string_view node) const { return find(node) != nullptr; }
  /// The node is heard, has recovered from its last fault, and its process has not ended.
  [[nodiscard]] bool alive(std::string_view node) const;
  /// The process has ended and no successor was heard, or the node never appeared.
  [[nodiscard]] bool ended(std::string_view node) const;
  /// Silence of the node's loop in stall-compensated time; empty: not heard yet.
  [[nodiscard]] std::optional<Time> silence(std::string_view node) const;
  /// The planner that commands the arm, or is to.
  [[nodiscard]] std::string in_charge(std::string_view arm) const;
  [[nodiscard]] DriverLoss loss_of_driver(std::string_view arm) const;
  /// The host of this node is heard and hears no other host.
  [[nodiscard]] bool is_isolated(std::string_view node) const;
  /// Why arms wait for this node: "planner/arm1 has not appeared yet"; CAUSE_NONE when it works.
  [[nodiscard]] msg::Cause awaited(std::string_view node) const;

 private:
  /// What is known of the process of a node.
  struct NodeRecord {
    std::int64_t pid = 0;               // as last heard or started; 0: unknown
    std::optional<ProcessExit> died{};  // unexpectedly, and no successor was heard
    bool stopped = false;               // was ordered to end, and did
    bool has_stream = false;
    std::optional<msg::Cause> failure{};        // as the node reports it
    std::optional<msg::Cause> device_fault{};   // as the driver reports it
    std::optional<ProcessExit> pending_exit{};  // not judged yet
    std::optional<Time> pending_exit_at{};      // when that was, if it is judged again
    Time died_at{0};                            // arrival of the report of `died`
    Time silence_at_end{0};                     // of the node, when the agent reported its last end
    std::optional<Time> returned_from{};        // end of the last absence of its host from which it has returned
    std::optional<KeyExpiry> keys{};            // as the node reports it
    Time heartbeat_at{0};                       // last one, of any process
    std::int64_t previous_pid = 0;              // heard before this process
    std::int64_t unreported_pid = 0;            // previous process whose end no agent has reported; 0: none
    Time changed_at{0};                         // when the heard process last changed
    int changes = 0;                            // changes between the same two processes without a pause
  };
  /// An exit (with a node) or a contact (without) that was judged.
  struct Transient {
    Time at{0};
    std::string node;
    ProcessExit exit;
    FaultObservation contact;
  };
  using FaultKey = std::pair<std::uint64_t, std::uint64_t>;  // opening term and number
  struct Contacts {
    std::uint64_t count = 0;
    bool known = false;  // the contact monitor was heard
    std::vector<FaultObservation> pending;
  };

  /// What nodes refuse now, by fault key.
  struct Refusals {
    FaultObservation observation;
    Time heard{0};
  };
  /// Of more senders at a time the rest is only in the heartbeats: a flood of forged ones must not hide other faults.
  static constexpr std::size_t kMostRefusals = 16;
  /// The fault ends when no node has reported it for this long.
  static constexpr Time kRefusalLasts = std::chrono::seconds(5);

  /// Helpers whose failures are faults at one time. A helper is a node that no arm needs, such as the recorder.
  static constexpr std::size_t kMostHelpers = 16;

  /// A process whose heartbeats continue for this long after the report of its end has not ended.
  static constexpr Time kFalseEnd = std::chrono::seconds(1);
  /// Heartbeats of two processes within this: both run at one time.
  static constexpr Time kDuplicate = std::chrono::seconds(1);

  /// Name of a node's stream of states in liveness_ and losses_.
  [[nodiscard]] static std::string stream_name(std::string_view node) { return std::string(node) + " stream"; }
  [[nodiscard]] const ExpectedNode* expected(std::string_view node) const;
  [[nodiscard]] const ExpectedNode* agent_of(std::string_view host) const;
  [[nodiscard]] const NodeRecord* find(std::string_view node) const;
  void note_process(NodeRecord& record, std::int64_t pid) const;
  void remember_transient(Transient transient);
  // The fault of a helper holds no arm. That of its end lasts until a successor is heard: of one that ends again and
  // again before its first heartbeat it stays.
  void helper_heard(std::string_view node, const Heartbeat& heartbeat);
  void raise_helper(std::string_view node, std::int64_t ended_pid, const FaultObservation& observation);
  void clear_helper(std::string_view node);

  // fault_rules.cpp
  void allow_for_losses();
  [[nodiscard]] int overdue_heartbeats(const ExpectedNode& node) const;
  void note_returns();
  void raise(const std::string& key, const FaultObservation& observation, Time now);
  void judge_hosts(Time now);
  void judge_links(Time now);
  void judge_nodes(Time now);
  void judge_duplicates(Time now);
  void judge_devices(Time now);
  void judge_contacts(Time now);
  void judge_refusals(Time now);
  void judge_keys(Time now);
  [[nodiscard]] FaultObservation observe_host(HostIndex host) const;
  [[nodiscard]] std::optional<FaultObservation> observe_node(const ExpectedNode& node) const;
  [[nodiscard]] std::optional<FaultObservation> observe_silence(const ExpectedNode& node, Presence presence) const;
  [[nodiscard]] std::optional<FaultObservation> observe_stream(const ExpectedNode& node) const;
  /// The node, or of an agent its host, has no fault of its own any more.
  [[nodiscard]] bool is_healthy(const ExpectedNode& node) const;
  [[nodiscard]] bool falls_behind(const ExpectedNode& node, Time limit) const;
  [[nodiscard]] bool is_explained(const ExpectedNode& node) const;
  [[nodiscard]] bool is_returning(const ExpectedNode& node) const;

  void hold_until_resumed();
  [[nodiscard]] AutomaticHolds holds() const;
  [[nodiscard]] bool holds_arms(const ExpectedNode& node) const;
  /// The fault that prevents the node from serving its arm; null: none.
  [[nodiscard]] const FaultRecord* fault_holding(const ExpectedNode& node) const;
  /// Why the node holds its arm, or the world the cell; empty: it does not.
  [[nodiscard]] std::optional<msg::Cause> hold_cause(const ExpectedNode& node) const;

  DetectionLimits limits_;
  std::vector<ExpectedNode> nodes_;
  std::map<std::string, NodeRecord, std::less<>> records_;  // by node
  Time now_;                                                // of this turn
  StallCompensatedClock clock_;                             // for silence; begins at 0
  Liveness liveness_;
  HostMonitor hosts_;
  PacketLossEstimator losses_;
  std::map<std::string, std::string, std::less<>> in_charge_;  // planner by arm, where there are several
  FaultList faults_;
  CellModeState mode_;
  Contacts contacts_;
  std::map<std::string, Refusals> refusals_;
  std::map<std::string, std::int64_t, std::less<>> helper_faults_;  // pid that ended; 0: it runs, but has failed
  std::deque<Transient> transients_;                                // newest last
  std::set<FaultKey> raised_;                           // open faults that this detector raised, not adopted
  std::set<std::pair<FaultKey, std::string>> ordered_;  // holds until resumed that were given: fault and arm; "": cell
  bool stalled_ = false;                                // the supervisor, before this turn
};

}  // namespace hecaton::services
