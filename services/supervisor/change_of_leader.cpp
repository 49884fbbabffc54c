// What a supervisor does when it begins to lead, and when it leads no more: so that the cell keeps its orders and its
// account of faults, whoever leads (docs/design/0003-supervision.md, 6 and 7).

#include <algorithm>
#include <limits>
#include <utility>

#include "services/runtime/log.hpp"
#include "services/supervisor/supervisor.hpp"

namespace hecaton::services {
namespace {

/// Between two requests to the leader for the same.
constexpr std::chrono::milliseconds kAskAgain{100};
/// What a leader saw so long before its last word reached us, it has told.
constexpr Time kTold = 2 * Supervisor::kRepeat;
/// So long after its last turn a process throws away what waits for it (services/bus/absence.hpp).
constexpr std::chrono::milliseconds kStall{250};

}  // namespace

// Who was stopped accuses nobody of the silence. It listens again before it leads, with a new term.
void Supervisor::come_back(bus::Clock::time_point now) {
  leadership_.absent(since_epoch(now));
  withdraw();
  tell_own_silence("was itself stopped and away", *absent_since_, now);
  absent_since_.reset();
}

// Of two this one tells, if it is still the leader: the other saw it, but tells nobody what a leader that goes on can.
void Supervisor::tell_stall(bus::Clock::time_point since, bus::Clock::time_point now) {
  if (now - since > std::max<Time>(file_.supervision.heartbeat_deadline, kStall)) {
    tell_own_silence("stood still", since, now);
  }
}

void Supervisor::tell_own_silence(const std::string& what, bus::Clock::time_point since, bus::Clock::time_point now) {
  const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - since);
  watch_.faults().raise(node_,
                        {FaultKind::kNodeSilent, FaultSeverity::kError, node_,
                         node_ + ": " + what + " for " + std::to_string(silence.count()) +
                             " ms; faults of that time may not have been seen",
                         silence},
                        since_epoch(since));
  watch_.faults().clear(node_, since_epoch(now));
  log_warning("supervisor " + what, {{"ms", silence.count()}});
}

// A driver that starts now must not follow what we granted: it has no memory of what was granted since.
void Supervisor::withdraw() {
  modes_.forget();
  if (!leads_) return;
  leads_ = false;
  order_legacy_.stand_back(watch_.mode().orders());
  legacy_.leave(watch_.faults().history(), led_under_);
  legacy_told_ = true;
}

void Supervisor::settle_legacy() {
  if (!legacy_told_) {
    legacy_told_ = true;
    const Clocks clocks = read_clocks();
    // Under no term, so that whatever somebody else told of them counts more.
    for (const auto& [id, left] : legacy_.left()) static_cast<void>(publish_fault(left.record, 0, clocks));
  }
  if (legacy_.strike_out(ears_.faults_of_others())) faults_.forget();
}

// A leader obeys it like people. Who has no writer matched yet is asked again.
void Supervisor::hand_over_orders() {
  const auto& leader = ears_.other_mode();
  if (!leader || order_legacy_.left().empty()) return;
  if (order_legacy_.strike_out(orders_in(*leader))) {
    log_info("the leader has our orders", {{"leader", leader->node()}, {"term", leader->term()}});
    return;
  }
  if (turned_ - handed_over_at_ < kAskAgain) return;
  handed_over_at_ = turned_;
  for (const msg::SupervisorRequest& request : requests_for(order_legacy_.left(), node_)) {
    log_warning("orders that the leader may not have heard", {{"leader", leader->node()}});
    static_cast<void>(requests_.write(request));  // the bus has logged a refusal
  }
}

void Supervisor::begin_to_lead() {
  watch_.faults().begin_life(leadership_.term());
  // After another leader its orders and faults hold; after our own earlier life those that we remember.
  const Time other_spoke = ears_.other_mode_at();
  const auto other = ears_.take_other_mode();
  if (other && other->term() >= led_under_) {
    watch_.mode().restore(orders_in(*other));
    watch_.faults().recall(faults_in(ears_.faults_of_others(), other->term(), read_clocks()));
    watch_.judge_again(other_spoke - kTold);
    for (const auto& [id, left] : legacy_.left()) watch_.adopt(left.cause, left.record, since_epoch(turned_));
    watch_.faults().clear(node_, since_epoch(turned_));  // whatever the other thought of us
  } else {
    watch_.faults().recall(watch_.faults().history());  // what we told under an earlier term, we tell under this one
  }
  ears_.adopt_faults(watch_, read_clocks());
  legacy_.clear();
  watch_.mode().add(order_legacy_.left());
  order_legacy_.begin_to_lead();
  leads_ = true;
  led_under_ = leadership_.term();
  constexpr auto kStrongest = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  modes_.set_strength(static_cast<int>(std::min(leadership_.term(), kStrongest)));
  log_info("supervisor leads", {{"term", leadership_.term()}});
}

void Supervisor::remember() {
  const bool alone = supervisors_.size() == 1;  // nobody else could lead without having heard
  keep({leadership_.term(), watch_.mode().orders(), watch_.mode().causes(), watch_.faults().history(),
        alone ? Orders{} : order_legacy_.unheard(watch_.mode().orders())});
}

void Supervisor::remember_leader() {
  const auto& leader = ears_.other_mode();
  if (!leader || !memory_.keeps()) return;
  const bool news = ears_.fault_news() != remembered_news_ || leader->sequence_number() != remembered_mode_;
  if (!news && (!memory_.forgetful() || turned_ - remembered_at_ < kRepeat)) return;
  remembered_at_ = turned_;
  Memory memory{leader->term(), orders_in(*leader), {}, memory_.kept().faults, order_legacy_.left()};
  if (ears_.fault_news() != remembered_news_ || memory_.forgetful()) {
    FaultList account;
    account.recall(faults_in(ears_.faults_of_others(), leader->term(), read_clocks()));
    for (const auto& [id, left] : legacy_.left()) account.adopt(left.cause, left.record, since_epoch(turned_));
    memory.faults = account.history();
  }
  remembered_news_ = ears_.fault_news();
  remembered_mode_ = leader->sequence_number();
  keep(std::move(memory));
}

// Tried again with every mode that is published, until there is room again.
void Supervisor::keep(Memory memory) {
  const bool was_forgetful = memory_.forgetful();
  memory_.keep(std::move(memory));
  const std::string cause = cause_of(FaultKind::kPersistenceFailed, node_);
  const Time now = since_epoch(bus::Clock::now());
  if (!memory_.forgetful()) {
    if (was_forgetful) log_info("orders are remembered again", {{"file", memory_.path()}});
    watch_.faults().clear(cause, now);
    return;
  }
  if (!was_forgetful) log_error("orders cannot be remembered", {{"file", memory_.path()}});
  watch_.faults().raise(
      cause, {FaultKind::kPersistenceFailed, FaultSeverity::kWarning, node_, node_ + ": " + memory_.failure()}, now);
}

}  // namespace hecaton::services
