#include "services/supervisor/replication/replicator.hpp"

#include <algorithm>
#include <utility>

#include "services/runtime/log.hpp"

namespace hecaton::services {
namespace {

/// Between two requests to the leader for the same.
constexpr std::chrono::milliseconds kAskAgain{100};
/// A leader has published what it saw so long before its last word reached us.
constexpr Time kTold = 2 * CellPublisher::kRepeat;

}  // namespace

Replicator::Replicator(std::string node, const std::string& checkpoint_path, bool alone)
    : node_(std::move(node)),
      alone_(alone),
      file_(checkpoint_path),
      orders_(file_.kept().unreplicated),
      led_under_(file_.kept().term) {
  faults_.leave(file_.kept().faults, file_.kept().term);
}

void Replicator::restore(FaultDetector& detector) {
  detector.mode().restore(file_.kept().orders, file_.kept().causes);
  detector.faults().recall(file_.kept().faults);
}

void Replicator::follow(const Cell& cell) {
  publish_left_faults(cell);
  hand_over_orders(cell);
  remember_leader(cell);
}

// Under term 0, so that what another supervisor publishes of them counts more.
void Replicator::publish_left_faults(const Cell& cell) {
  if (!std::exchange(faults_published_, true)) {
    for (const auto& [id, left] : faults_.left()) static_cast<void>(cell.publisher.publish(left.record, 0));
  }
  if (faults_.strike_out(cell.subscriptions.faults_of_others())) cell.publisher.withdraw_faults();
}

// The leader obeys such a request like a person's. A leader whose reader is not matched yet is asked again.
void Replicator::hand_over_orders(const Cell& cell) {
  const auto& leader = cell.subscriptions.other_mode();
  if (!leader || orders_.left().empty()) return;
  if (orders_.strike_out(orders_in(*leader))) {
    log_info("the leader has our orders", {{"leader", leader->node()}, {"term", leader->term()}});
    return;
  }
  if (cell.now - handed_over_at_ < kAskAgain) return;
  handed_over_at_ = cell.now;
  log_warning("orders that the leader may not have heard", {{"leader", leader->node()}});
  cell.publisher.request(orders_.left());
}

void Replicator::remember_leader(const Cell& cell) {
  const auto& leader = cell.subscriptions.other_mode();
  if (!leader || !file_.keeps()) return;
  const bool fault_news = cell.subscriptions.fault_news() != written_.fault_news;
  const bool news = fault_news || leader->sequence_number() != written_.mode;
  if (!news && (!file_.failed() || cell.now - written_.at < CellPublisher::kRepeat)) return;
  Checkpoint checkpoint{leader->term(), orders_in(*leader), {}, file_.kept().faults, orders_.left()};
  if (fault_news || file_.failed()) {
    FaultList account;
    account.recall(faults_in(cell.subscriptions.faults_of_others(), leader->term(), read_clocks()));
    for (const auto& [id, left] : faults_.left()) account.adopt(left.cause, left.record, since_epoch(cell.now));
    checkpoint.faults = account.history();
  }
  written_ = {cell.subscriptions.fault_news(), leader->sequence_number(), cell.now};
  write(std::move(checkpoint), cell.detector.faults());
}

void Replicator::begin_to_lead(const Cell& cell) {
  FaultDetector& detector = cell.detector;
  const Time now = since_epoch(cell.now);
  detector.faults().begin_life(cell.term);
  // After another leader its orders and faults hold; after our own earlier life those that we remember.
  const Time other_spoke = cell.subscriptions.other_mode_at();
  const auto other = cell.subscriptions.take_other_mode();
  if (other && other->term() >= led_under_) {
    detector.mode().restore(orders_in(*other));
    detector.faults().recall(faults_in(cell.subscriptions.faults_of_others(), other->term(), read_clocks()));
    detector.judge_again(other_spoke - kTold);
    for (const auto& [id, left] : faults_.left()) detector.adopt(left.cause, left.record, now);
    detector.faults().clear(node_, now);  // whatever the other thought of us
  } else {
    detector.faults().recall(detector.faults().history());  // to be published once more, under this term
  }
  cell.subscriptions.adopt_faults(detector, read_clocks());
  faults_.clear();
  detector.mode().add(orders_.left());
  orders_.begin_to_lead();
  leads_ = true;
  led_under_ = cell.term;
}

void Replicator::stand_back(const Cell& cell) {
  if (!std::exchange(leads_, false)) return;
  orders_.stand_back(cell.detector.mode().orders());
  faults_.leave(cell.detector.faults().history(), led_under_);
  faults_published_ = true;
}

void Replicator::about_to_publish(const Cell& cell, const msg::CellMode& mode) {
  orders_.published(cell.detector.mode().orders(), mode.sequence_number());
  remember(cell);
}

void Replicator::standby_received(const Cell& cell, std::uint64_t mode) {
  if (orders_.heard(mode)) remember(cell);
}

void Replicator::remember(const Cell& cell) {
  const CellModeState& mode = cell.detector.mode();
  // Where there is no other supervisor none could lead without having heard.
  write({cell.term, mode.orders(), mode.causes(), cell.detector.faults().history(),
         alone_ ? Orders{} : orders_.unheard(mode.orders())},
        cell.detector.faults());
}

void Replicator::write(Checkpoint checkpoint, FaultList& faults) {
  const bool failed_before = file_.failed();
  file_.keep(std::move(checkpoint));
  const std::string cause = cause_of(msg::CauseKind::CAUSE_PERSISTENCE_FAILED, node_);
  const Time now = since_epoch(bus::Clock::now());
  if (!file_.failed()) {
    if (failed_before) log_info("orders are remembered again", {{"file", file_.path()}});
    faults.clear(cause, now);
    return;
  }
  if (!failed_before) log_error("orders cannot be remembered", {{"file", file_.path()}});
  faults.raise(cause,
               {msg::CauseKind::CAUSE_PERSISTENCE_FAILED, msg::Severity::SEVERITY_WARNING, node_,
                node_ + ": " + file_.failure()},
               now);
}

msg::Cause Replicator::persistence_cause(msg::CauseKind kind) const {
  return file_.failed() ? make_cause(kind, node_, file_.failure()) : msg::Cause();
}

}  // namespace hecaton::services
