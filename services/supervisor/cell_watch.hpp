#pragma once
/// From signs of life, process events and orders to faults and the cell's mode: the whole judgement of the supervisor.
/// Standard library only: time is an argument, so that every fault can be tested without a network.
///
/// One turn of its owner's loop: advance(now), everything that was heard, judge(now).

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/supervisor/cell_mode.hpp"
#include "services/supervisor/fault_list.hpp"
#include "services/supervisor/host_watch.hpp"
#include "services/supervisor/liveness.hpp"
#include "services/supervisor/reception.hpp"
#include "services/supervisor/watch_limits.hpp"

namespace hecaton::services {

/// A heartbeat.
struct Beat {
  std::int64_t pid = 0;
  Time at{0};                ///< when it arrived
  std::uint64_t number = 0;  ///< the process counts its heartbeats from 1; 0: unknown
  HeardMode heard{};         ///< the cell mode that it has heard last
  /// Why the node cannot do its work, as it says itself; empty: it can.
  std::optional<msg::Cause> failure{};
};

struct ProcessExit {
  std::int64_t pid = 0;
  int exit_code = 0;
  int signal_number = 0;  ///< 0: it returned
  bool wanted = false;    ///< it was told to
  /// When, if it was before we met its agent, or was told late; otherwise just now.
  std::optional<Time> at{};
  msg::Cause cause{};  ///< why its agent ended it, unasked; CAUSE_NONE: it did not
};

/// "process 123 was ended by signal 9 (Killed)", "its agent ended process 123: its loop was silent for 10012 ms"
[[nodiscard]] std::string end_text(const ProcessExit& exit);

/// Under which a node's fault of this kind is listed: most explain each other, and share one.
[[nodiscard]] std::string cause_of(msg::CauseKind kind, const std::string& node);

/// Why nothing is heard of an arm's driver.
enum class Loss : std::uint8_t {
  kNone,       ///< it is heard, or may be heard again in a moment
  kEnded,      ///< its process has ended, as its agent says
  kHostSilent  ///< its host was lost, while most hosts of the cell are heard: so nobody else can conclude this of us
};

class CellWatch {
 public:
  /// `host`: the one that we are on; empty: none of the cell's.
  CellWatch(std::vector<ExpectedNode> nodes, std::vector<std::string> arms, const WatchLimits& limits, Time now,
            std::string host = {});
  CellWatch(const CellWatch&) = delete;
  CellWatch& operator=(const CellWatch&) = delete;

  void advance(Time now);
  /// Unknown nodes are ignored, here and below.
  void heard(std::string_view node, const Beat& beat);
  /// ArmState from a driver, ObstacleStates from the world: signs of life of the loop, too. `number`: as in Beat.
  void stream_heard(std::string_view node, Time at, std::uint64_t number = 0);
  void process_started(std::string_view node, std::int64_t pid);
  /// `news`: to be told even when its successor is there before the next judgement; otherwise an end that somebody may
  /// have told already matters only as long as nobody has taken its place.
  void process_exited(std::string_view node, const ProcessExit& exit, bool news = true);
  /// What the referee has counted in all, and the latest of them. Those of before the first call count as seen where a
  /// contact is remembered.
  void contacts(std::uint64_t count, const std::string& subject, const std::string& seen);
  /// A fault that another supervisor told while it led. It lasts as long as its cause does in our own judgement; what
  /// we do not judge (ourselves, a contact) is over.
  void adopt(const std::string& cause, const FaultRecord& record, Time now);
  /// Of an arm with a standby: only the faults of this planner hold the arm.
  void put_in_charge(const std::string& arm, const std::string& planner) { in_charge_[arm] = planner; }
  /// We begin to lead, and our list has become that of who led until it fell silent, so long ago. Nodes that we have
  /// not heard for longer than it would have kept that to itself, it did hear: it is we who were cut off from their
  /// hosts, and have not met them anew. Nobody is told as silent there until it has had the time to return.
  void succeed(std::string_view predecessor, Time silence);
  /// We lead under this term, and our list is that of who led before. Until a node of another host has heard it, nobody
  /// may hear us.
  void begin_to_lead(std::uint64_t term);
  void stand_back() { hosts_.stand_back(); }
  /// We have published the cell mode of this number: somebody elsewhere should say soon that it was heard.
  void mode_published(std::uint64_t number) { hosts_.said(number); }
  /// Nobody there has said so for a while.
  [[nodiscard]] bool unheard() const { return hosts_.unheard() && hosts_.unanswered_for_long(); }
  void judge(Time now);
  /// What came and went since `since` is judged once more by the next judge(), as far as our list, which may have
  /// become another's meanwhile, does not have it: of two supervisors the other may have been lost before it told.
  void judge_again(Time since);

  [[nodiscard]] FaultList& faults() { return faults_; }
  [[nodiscard]] const FaultList& faults() const { return faults_; }
  [[nodiscard]] CellModeState& mode() { return mode_; }
  [[nodiscard]] const CellModeState& mode() const { return mode_; }
  [[nodiscard]] const PunctualClock& clock() const { return clock_; }
  [[nodiscard]] const std::vector<ExpectedNode>& nodes() const { return nodes_; }

  [[nodiscard]] bool expects(std::string_view node) const { return find(node) != nullptr; }
  /// Heard, not for the first time after a fault, and its process is not known to be dead.
  [[nodiscard]] bool alive(std::string_view node) const;
  /// Its process has ended and no successor was heard of, or it never appeared.
  [[nodiscard]] bool ended(std::string_view node) const;
  /// Of its loop, in punctual time; empty: not heard yet.
  [[nodiscard]] std::optional<Time> silence(std::string_view node) const;
  /// The planner that commands the arm, or is to.
  [[nodiscard]] std::string in_charge(std::string_view arm) const;
  [[nodiscard]] Loss loss_of(std::string_view arm) const;
  /// What a node is being waited for: "planner/arm1 has not appeared yet"; CAUSE_NONE when it is there.
  [[nodiscard]] msg::Cause awaited(std::string_view node) const;

 private:
  struct State {
    std::int64_t pid = 0;             // as last heard or started; 0: unknown
    std::optional<ProcessExit> died;  // and nothing was heard of a successor
    bool stopped = false;             // was told to end, and did
    bool has_stream = false;
    std::optional<msg::Cause> failure{};    // in its own words
    std::optional<ProcessExit> unjudged{};  // an end that no judgement has seen, whoever came after it
    Time silence_at_end{0};                 // when its last end was told
    std::optional<Time> unjudged_since{};   // when that unjudged end was, if it is judged once more
    Time beat_at{0};                        // the last, of whichever process
    std::int64_t former_pid = 0;            // that beat before this one
    std::int64_t untold_pid = 0;            // beat before this one, and nobody has told that it ended; 0: none
    Time returned_at{0};                    // when that last changed
    int returns = 0;                        // of one of the two after the other, without a pause
  };
  /// Of its states, beside its heartbeats.
  [[nodiscard]] static std::string stream_name(std::string_view node);
  [[nodiscard]] const ExpectedNode* expected(std::string_view node) const;
  [[nodiscard]] const State* find(std::string_view node) const;
  [[nodiscard]] Presence presence_of(const ExpectedNode& node) const;
  [[nodiscard]] bool sound(const ExpectedNode& node) const;
  [[nodiscard]] std::optional<FaultSight> sight(const ExpectedNode& node) const;
  [[nodiscard]] FaultSight own_host_sight(const ExpectedNode& agent) const;
  [[nodiscard]] std::optional<FaultSight> silence_sight(const ExpectedNode& node, Presence presence) const;
  [[nodiscard]] std::optional<FaultSight> stream_sight(const ExpectedNode& node) const;
  /// An end, or a contact (no node), as it was judged.
  struct Passing {
    Time at{0};
    std::string node;
    ProcessExit exit;
    FaultSight contact;
  };
  void note_passing(Passing passing);
  void note_process(State& state, std::int64_t pid) const;
  /// Whatever the network loses, no node is silent for it.
  void allow_for_losses();
  /// So many heartbeats of the node are late already, and may yet come.
  [[nodiscard]] int late_beats(const ExpectedNode& node) const;
  void judge_twins(Time now);
  void judge_contacts(Time now);
  [[nodiscard]] AutomaticHolds holds() const;
  /// What its being out does to others is this fault's doing; null: no fault's.
  [[nodiscard]] const FaultRecord* fault_holding(const ExpectedNode& node) const;
  /// Why the node holds its arm, or the world the cell; empty: it does not.
  [[nodiscard]] std::optional<msg::Cause> hold_cause(const ExpectedNode& node) const;
  [[nodiscard]] bool holds_arms(const ExpectedNode& node) const;

  WatchLimits limits_;
  std::vector<ExpectedNode> nodes_;
  std::map<std::string, State, std::less<>> states_;
  PunctualClock clock_;
  Liveness liveness_;
  HostWatch hosts_;
  Reception reception_;
  std::map<std::string, std::string, std::less<>> in_charge_;  // arm → planner, where there are several
  FaultList faults_;
  CellModeState mode_;
  std::uint64_t contacts_ = 0;   // told so far
  bool contacts_known_ = false;  // the referee was heard
  std::vector<FaultSight> untold_contacts_;
  std::deque<Passing> passing_;  // newest last
  bool stalled_ = false;
};

}  // namespace hecaton::services
