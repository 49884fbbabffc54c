#pragma once
/// The hosts of a cell by what is heard of their nodes: which are silent, which were lost, and whose nodes are on their
/// way back and not to be blamed one by one (docs/design/0003-supervision.md). Standard library only; all time is
/// punctual.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "services/supervisor/echo.hpp"
#include "services/supervisor/liveness.hpp"
#include "services/supervisor/watch_limits.hpp"

namespace hecaton::services {

class HostWatch {
 public:
  /// All must outlive it. `own`: the host that we are on; one without an agent: none.
  HostWatch(const std::vector<ExpectedNode>& nodes, const WatchLimits& limits, const PunctualClock& clock,
            const Liveness& liveness, std::string own)
      : nodes_(nodes), limits_(limits), clock_(clock), liveness_(liveness), own_(std::move(own)) {}

  /// Once in a turn, after the liveness was judged.
  void judge();

  [[nodiscard]] const ExpectedNode* agent_of(const std::string& host) const;
  /// Nothing at all was heard of it for about a beat: whether one node hangs or the host is gone cannot be told yet.
  [[nodiscard]] bool silent(const std::string& host) const;
  [[nodiscard]] bool silent_for(const std::string& host, Time duration) const;
  [[nodiscard]] bool most_are_heard() const;
  /// For so long no agent of another host has been heard, where several fell silent within a lease: rather than all of
  /// them ours was cut off. (A process there that has just begun may know us all the same.) Empty: it was one, and
  /// either may be.
  [[nodiscard]] std::optional<Time> alone_for() const;
  /// It has been so for a lease, and no agent is well again: whatever is not heard of them is our own host's fault.
  [[nodiscard]] bool cut_off() const { return cut_off_; }
  [[nodiscard]] const std::string& own() const { return own_; }
  /// We lead under this term; `lost`: the hosts that who led before has told as lost.
  void begin_to_lead(std::uint64_t term, std::set<std::string> lost);
  void stand_back() { echo_.end(); }
  /// We have published the cell mode of this number.
  void said(std::uint64_t number) { echo_.said(number, clock_.now()); }
  /// A node there has heard this cell mode last.
  void heard_mode(const std::string& host, const HeardMode& mode);
  /// We lead, and nobody of another host is known to have heard it yet, or what we said since. Not for longer than who
  /// has left us alone takes to return.
  [[nodiscard]] bool unanswered() const;
  /// For longer than it can take where anybody hears us.
  [[nodiscard]] bool unanswered_for_long() const;
  /// It is unanswered though several hosts are there: rather than all of them it is ours that is not heard, and they
  /// leave us alone one after the other.
  [[nodiscard]] bool unheard() const { return unanswered() && others().size() > 1; }
  /// Whatever this node says or not is its host's doing, or ours.
  [[nodiscard]] bool explain(const ExpectedNode& node) const;
  /// What is not heard of the host is put down to ourselves, who were cut off from it: others hear it.
  void meet_anew(const std::string& host);
  /// The silence of this node, which may be an agent, is: until it has been heard for long enough that the reunion will
  /// not take it away again, or has had the time to return.
  [[nodiscard]] bool put_down_to_us(const ExpectedNode& node) const {
    const bool host_may_be_lost = node.role == msg::NodeKind::NODE_AGENT && !unheard();
    return meets_anew_.contains(node.name) || (unanswered() && node.host != own_ && !host_may_be_lost);
  }

 private:
  /// Of a host of which nothing was heard for a lease.
  struct Absence {
    Time silent{0};                           // last, when nothing was heard of any of its nodes
    Time away{0};                             // last, when its agent was not well
    std::set<std::string, std::less<>> back;  // nodes that have returned since
  };
  void judge_own();
  /// The host was lost before nobody heard us any more.
  [[nodiscard]] bool lost_before(const std::string& host) const;
  /// Agents of other hosts that were heard; while nobody hears us, without those that were lost before.
  [[nodiscard]] std::vector<const ExpectedNode*> others() const;
  /// Alone for so long, we put it down to ourselves.
  [[nodiscard]] Time loneliness() const;
  /// Whom we meet anew since then is back, or has had the time to return.
  [[nodiscard]] bool has_met(const std::string& node, Time since) const;
  /// A silence of a whole host that is this long explains that its nodes return one after the other.
  [[nodiscard]] Time pause() const;
  [[nodiscard]] bool returns(const ExpectedNode& node) const;

  const std::vector<ExpectedNode>& nodes_;
  const WatchLimits& limits_;
  const PunctualClock& clock_;
  const Liveness& liveness_;
  std::string own_;
  std::map<std::string, Time, std::less<>> silences_;  // when all of a host was last silent
  std::map<std::string, Absence, std::less<>> absences_;
  std::map<std::string, Time, std::less<>> meets_anew_;  // since when, by node
  Echo echo_;
  std::set<std::string> lost_before_;  // hosts, as who led before has told; until we are followed
  bool cut_off_ = false;
};

}  // namespace hecaton::services
