#include "services/supervisor/replication/replicator.hpp"

#include <algorithm>
#include <utility>

#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

/// Between two requests to the leader for the same orders.
constexpr std::chrono::milliseconds kForwardPeriod{100};
/// A leader published what it had observed up to this long before its last cell mode arrived.
constexpr Time kPublishingDelay = 2 * CellPublisher::kRepeat;

}  // namespace

Replicator::Replicator(std::string node, const std::string& checkpoint_path, bool alone)
    : node_(std::move(node)),
      alone_(alone),
      file_(checkpoint_path),
      orders_(file_.stored().unreplicated),
      last_term_(file_.stored().term) {
  faults_.step_down(file_.stored().faults, file_.stored().term);
}

void Replicator::restore(FaultDetector& detector) {
  detector.mode().restore(file_.stored().orders, file_.stored().causes);
  detector.faults().restore(file_.stored().faults);
  if (!file_.lost()) return;
  log_error("checkpoint lost", {{"reason", *file_.lost()}});
  detector.mode().hold_until_resumed({}, make_cause(msg::CauseKind::CAUSE_CHECKPOINT_LOST, node_, *file_.lost()));
  static_cast<void>(detector.mode().slow_down({}, kSlowestSpeed));  // a low speed may have been ordered, too
  tell_lost(detector);
}

// The order to hold remains; the fault itself is over once the new checkpoint is in use.
void Replicator::tell_lost(FaultDetector& detector) const {
  const std::string key = node_fault_key(msg::CauseKind::CAUSE_CHECKPOINT_LOST, node_);
  const Time now = since_epoch(bus::Clock::now());
  detector.faults().raise(
      key, {msg::CauseKind::CAUSE_CHECKPOINT_LOST, msg::Severity::SEVERITY_ERROR, node_, node_ + ": " + *file_.lost()},
      now);
  detector.faults().clear(key, now);
}

void Replicator::follow_leader(const Cell& cell) {
  republish_faults(cell);
  forward_orders(cell);
  remember_leader(cell);
}

// Under term 0: what another supervisor publishes of these faults takes precedence.
void Replicator::republish_faults(const Cell& cell) {
  if (!std::exchange(faults_published_, true)) {
    for (const auto& [id, keyed] : faults_.pending()) static_cast<void>(cell.publisher.publish(keyed.record, 0));
  }
  if (faults_.remove_published(cell.subscriptions.published_by_others())) cell.publisher.withdraw_faults();
}

// The leader executes such a request like a person's. Discovery may not have matched its reader yet, so the request is
// repeated.
void Replicator::forward_orders(const Cell& cell) {
  const auto& leader = cell.subscriptions.leader_mode();
  if (!leader || orders_.pending().empty()) return;
  if (orders_.remove_published(orders_in(*leader))) {
    log_info("leader has taken over the orders", {{"leader", leader->node()}, {"term", leader->term()}});
    return;
  }
  if (cell.now - forwarded_at_ < kForwardPeriod) return;
  forwarded_at_ = cell.now;
  log_warning("leader may not have these orders: requested again", {{"leader", leader->node()}});
  cell.publisher.request(orders_.pending());
}

void Replicator::remember_leader(const Cell& cell) {
  const auto& leader = cell.subscriptions.leader_mode();
  if (!leader || !file_.has_file()) return;
  const bool new_faults = cell.subscriptions.fault_revision() != written_.fault_revision;
  const bool news = new_faults || leader->sequence_number() != written_.mode;
  if (!news && (!file_.failed() || cell.now - written_.at < CellPublisher::kRepeat)) return;
  Checkpoint checkpoint{leader->term(), orders_in(*leader), device_causes_in(*leader), file_.stored().faults,
                        orders_.pending()};
  if (new_faults || file_.failed()) {
    FaultList faults;
    faults.restore(fault_history_of(cell.subscriptions.published_by_others(), leader->term(), read_clocks()));
    for (const auto& [id, keyed] : faults_.pending()) faults.adopt(keyed.key, keyed.record, since_epoch(cell.now));
    checkpoint.faults = faults.history();
  }
  written_ = {cell.subscriptions.fault_revision(), leader->sequence_number(), cell.now};
  write(std::move(checkpoint), cell.detector.faults());
}

void Replicator::become_leader(const Cell& cell) {
  FaultDetector& detector = cell.detector;
  const Time now = since_epoch(cell.now);
  detector.faults().begin_term(cell.term);
  // The orders and faults of the previous leader are in force; without one those of the own checkpoint.
  const Time leader_heard_at = cell.subscriptions.leader_heard_at();
  const auto leader = cell.subscriptions.take_leader_mode();
  if (leader && leader->term() >= last_term_) {
    detector.mode().restore(orders_in(*leader), device_causes_in(*leader));
    detector.faults().restore(
        fault_history_of(cell.subscriptions.published_by_others(), leader->term(), read_clocks()));
    detector.judge_again(leader_heard_at - kPublishingDelay);
    for (const auto& [id, keyed] : faults_.pending()) detector.adopt(keyed.key, keyed.record, now);
    detector.faults().clear(node_, now);  // the previous leader's fault of this supervisor
  } else {
    detector.faults().restore(detector.faults().history());  // to publish them again, under this term
  }
  cell.subscriptions.adopt_faults(detector, read_clocks());
  faults_.clear();
  detector.mode().add(orders_.pending());
  orders_.become_leader();
  leads_ = true;
  last_term_ = cell.term;
}

void Replicator::step_down(const Cell& cell) {
  if (!std::exchange(leads_, false)) return;
  orders_.step_down(cell.detector.mode().orders());
  faults_.step_down(cell.detector.faults().history(), last_term_);
  faults_published_ = true;
}

void Replicator::before_publish(const Cell& cell, const msg::CellMode& mode) {
  orders_.published(cell.detector.mode().orders(), mode.sequence_number());
  remember(cell);
}

void Replicator::standby_acknowledged(const Cell& cell, std::uint64_t mode) {
  if (orders_.acknowledged(mode)) remember(cell);
}

void Replicator::remember(const Cell& cell) {
  const CellModeState& mode = cell.detector.mode();
  // Without another supervisor nothing is unreplicated.
  write({cell.term, mode.orders(), mode.causes(), cell.detector.faults().history(),
         alone_ ? Orders{} : orders_.unacknowledged(mode.orders())},
        cell.detector.faults());
}

void Replicator::write(Checkpoint checkpoint, FaultList& faults) {
  const bool failed_before = file_.failed();
  file_.store(std::move(checkpoint));
  const std::string key = node_fault_key(msg::CauseKind::CAUSE_PERSISTENCE_FAILED, node_);
  const Time now = since_epoch(bus::Clock::now());
  if (!file_.failed()) {
    if (failed_before) log_info("checkpoint written again", {{"file", file_.path()}});
    faults.clear(key, now);
    return;
  }
  if (!failed_before) log_error("checkpoint cannot be written", {{"file", file_.path()}, {"reason", file_.failure()}});
  faults.raise(key,
               {msg::CauseKind::CAUSE_PERSISTENCE_FAILED, msg::Severity::SEVERITY_WARNING, node_,
                node_ + ": " + file_.failure()},
               now);
}

msg::Cause Replicator::persistence_cause(msg::CauseKind kind) const {
  return file_.failed() ? make_cause(kind, node_, file_.failure()) : msg::Cause();
}

}  // namespace hecaton::services
