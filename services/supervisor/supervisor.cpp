#include "services/supervisor/supervisor.hpp"

#include <algorithm>
#include <utility>

#include "services/arm_driver/device_choice.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/supervisor/cell_publisher.hpp"
#include "services/supervisor/cell_status.hpp"
#include "services/supervisor/expected_nodes.hpp"

namespace hecaton::services {
namespace {

constexpr std::chrono::minutes kUnknownNodeRemembered{1};
/// Longer than discovery of two processes takes on a busy machine.
constexpr std::chrono::seconds kSearch{2};
/// A process whose last turn is longer ago discards samples that wait for it (services/bus/local_stall_guard.hpp).
constexpr std::chrono::milliseconds kStall{250};

SupervisorPlace place_of(const config::CellFile& file, const ServiceOptions& options) {
  SupervisorPlace place{supervisors_of(file), 0, {}, {}};
  place.index = index_on(place.supervisors, options.host);
  const PlacedNode& ours = place.supervisors[place.index];
  place.node = ours.node;
  place.host = options.host.empty() ? ours.host : options.host;
  return place;
}

/// The second supervisor listens longer, so that the first one leads when the cell comes up. A long host lease is for
/// machines on which processes wait for a processor: there a leader may be silent longer, too.
Leadership::Limits leadership_limits(const SupervisorPlace& place, Time host_lease) {
  Leadership::Limits limits;
  limits.silence = std::max(limits.silence, host_lease * 3 / 5);
  limits.listen *= static_cast<int>(place.index) + 1;
  limits.search = place.supervisors.size() > 1 ? kSearch + limits.listen : limits.listen;
  return limits;
}

void log_fault(const msg::Fault& fault) {
  const LogFields fields{{"id", fault.id()},
                         {"kind", cause_name(fault.cause().kind())},
                         {"subject", fault.cause().subject()},
                         {"description", fault.cause().text()}};
  if (fault.cleared()) {
    log_info("fault cleared", fields);
  } else {
    log_warning("fault", fields);
  }
}

}  // namespace

std::vector<msg::SupervisorRequest> RequestQueue::take(std::vector<bus::Sample<msg::SupervisorRequest>> arrived,
                                                       Leadership::Role role) {
  const bool leads = role == Leadership::Role::kLeading;
  if (role == Leadership::Role::kStandingBy) waiting_.clear();
  std::vector<msg::SupervisorRequest> now;
  if (leads) now = std::exchange(waiting_, {});
  const bool answers = leads || (role == Leadership::Role::kListening && alone_);
  for (auto& sample : arrived) {
    if (!answers || sample.disposed) continue;
    const bool at_once = leads || sample.value.kind() == msg::RequestKind::REQUEST_STATUS;
    (at_once ? now : waiting_).push_back(std::move(sample.value));
  }
  return now;
}

void StartupLog::update(const FaultDetector& detector, bus::Clock::time_point now) {
  if (complete_) return;
  const auto& nodes = detector.nodes();
  const auto heard = [&](const ExpectedNode& node) { return detector.silence(node.name).has_value(); };
  if (!first_heard_ && std::any_of(nodes.begin(), nodes.end(), heard)) first_heard_ = now;
  complete_ = first_heard_ && std::all_of(nodes.begin(), nodes.end(), heard);
  if (!complete_) return;
  const auto since = [&](bus::Clock::time_point at) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(now - at).count();
  };
  log_info("all nodes heard",
           {{"nodes", nodes.size()}, {"after_ms", since(*first_heard_)}, {"after_matching_ms", since(newest_match_)}});
}

Supervisor::Connection::Connection(const config::CellFile& file, const ServiceOptions& options, const std::string& node)
    : participant(make_participant(file, options, Role::kSupervisor, node, &quiet)) {}

Supervisor::Supervisor(const config::CellFile& file, const ServiceOptions& options, ShutdownSignal& shutdown)
    : file_(file),
      stop_without_driver_(stop_without_driver(file)),
      place_(place_of(file, options)),
      shutdown_(shutdown),
      turns_{bus::Clock::now(), bus::Clock::now()},
      detector_(expected_nodes(file, place_.node), arm_names(file), detection_limits(file, kTurn),
                since_epoch(turns_.began), place_.host),
      replicator_(place_.node, options.checkpoint, place_.supervisors.size() == 1),
      planners_(arms_with_standby(file), {file.supervision.failover_timeout, file.supervision.host_lease},
                turns_.began),
      requests_(place_.supervisors.size() == 1),
      connection_(file, options, place_.node),
      subscriptions_(connection_.participant, {place_.node, place_.host, replicator_.checkpoint().term > 0},
                     connection_.urgent, connection_.quiet),
      leadership_(leadership_limits(place_, file.supervision.host_lease), replicator_.remembered_term(),
                  since_epoch(bus::Clock::now()), {place_.index, place_.supervisors.size()}),
      publisher_(connection_.participant, place_.node),
      heartbeats_{
          HeartbeatPublisher(connection_.participant, {place_.node, msg::NodeKind::NODE_SUPERVISOR, {}, place_.host},
                             heartbeat_timing(file, options)),
          {}} {
  connection_.participant.know_term(replicator_.remembered_term());
  replicator_.restore(detector_);
  shutdown_.wake(&connection_.urgent);
}

Supervisor::~Supervisor() {
  shutdown_.wake(nullptr);
}

void Supervisor::run() {
  log_info("supervisor started", {{"cell", file_.cell.name}, {"remembered_term", replicator_.checkpoint().term}});
  auto deadline = bus::Clock::now();
  while (!shutdown_.requested()) {
    const auto until = std::min(deadline, turns_.failover_due);
    static_cast<void>(connection_.urgent.wait(std::max(until - bus::Clock::now(), bus::Clock::duration::zero())));
    const auto now = bus::Clock::now();
    if (now >= deadline) {
      const NextDeadline next = next_deadline(deadline, now, kTurn);
      heartbeats_.loop.record_lateness(std::max(now - deadline, bus::Clock::duration::zero()), next.skipped);
      deadline = next.at;
    }
    turn(now);
    heartbeats_.loop.record_tick(bus::Clock::now() - now);
  }
  log_info("supervisor ends", {{"term", leadership_.term()}});
}

void Supervisor::turn(bus::Clock::time_point now) {
  if (!is_present(now)) return;
  const auto last_turn = std::exchange(turns_.last, now);
  const bool led = is(Leadership::Role::kLeading);
  receive(now);
  decide_leadership(led, last_turn);
  if (is(Leadership::Role::kStandingBy)) replicator_.follow_leader(replicated());
  assign_planners();
  judge();
  if (is(Leadership::Role::kLeading)) publish_mode(now);
  publish_faults();
  answer();
  startup_.update(detector_, now);
  if (heartbeats_.publisher.due(now, kTurn / 2)) publish_heartbeat(now);
}

// A supervisor that was stopped reports no other node for the silence. It listens again and then leads under a new
// term.
bool Supervisor::is_present(bus::Clock::time_point now) {
  if (connection_.participant.recovering()) {
    if (!turns_.absent_since) turns_.absent_since = turns_.last;
    turns_.failover_due = bus::Clock::time_point::max();  // or the loop would not wait
    return false;
  }
  if (turns_.absent_since) {
    leadership_.restart_listening(since_epoch(now));
    step_down();
    report_own_stall("was itself stopped and away", *std::exchange(turns_.absent_since, std::nullopt));
  }
  return true;
}

void Supervisor::receive(bus::Clock::time_point now) {
  // First the clock: a silence may end with a sample that has arrived already.
  detector_.advance(since_epoch(now));
  for (const bus::Event& event : connection_.quiet.take_events()) {
    if (event.kind == bus::EventKind::kPeerMatched) startup_.matched(event.at);
  }
  static_cast<void>(connection_.urgent.take_events());
  subscriptions_.receive(publisher_.id(), {snapshot_, detector_, leadership_, planners_.failover()});
  std::erase_if(snapshot_.heartbeats, [&](const auto& entry) {
    return !detector_.expects(entry.first) && now - entry.second.at > kUnknownNodeRemembered;
  });
}

void Supervisor::decide_leadership(bool led, bus::Clock::time_point last_turn) {
  const bool replaced = led && !is(Leadership::Role::kLeading);
  if (replaced) {
    log_warning("another supervisor leads", {{"own_term", leadership_.term()}});
    step_down();  // keeps unreplicated orders, even if the next decision makes this supervisor leader again
  }
  // A leader on an isolated host knows nothing of the cell, and no order reaches it.
  const auto& leader = subscriptions_.leader_mode();
  if (leader && detector_.is_isolated(leader->node())) leadership_.leader_died();
  if (is(Leadership::Role::kListening) && another_joins()) leadership_.observe_joining(since_epoch(turns_.last));
  if (leadership_.decide(since_epoch(turns_.last), subscriptions_.newest_arrival())) {
    replicator_.become_leader(replicated());
    log_info("supervisor leads", {{"term", leadership_.term()}});
  }
  // A leader that continues reports its own stall, because a standby that observed it publishes nothing.
  const bool continues = led && !replaced;
  if (continues && turns_.last - last_turn > std::max<Time>(file_.supervision.heartbeat_deadline, kStall)) {
    report_own_stall("stood still", last_turn);
  }
}

bool Supervisor::another_joins() const {
  if (file_.keystore.empty()) return false;
  const auto joining = connection_.participant.joining();
  return std::any_of(joining.begin(), joining.end(), [&](const std::string& name) {
    return name != place_.node && std::any_of(place_.supervisors.begin(), place_.supervisors.end(),
                                              [&](const PlacedNode& one) { return one.node == name; });
  });
}

void Supervisor::report_own_stall(const std::string& what, bus::Clock::time_point since) {
  const auto now = bus::Clock::now();
  const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - since);
  detector_.faults().raise(place_.node,
                           {msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_ERROR, place_.node,
                            place_.node + ": " + what + " for " + std::to_string(silence.count()) +
                                " ms; faults during that time may be missing",
                            silence},
                           since_epoch(since));
  detector_.faults().clear(place_.node, since_epoch(now));
  log_warning("supervisor " + what, {{"ms", silence.count()}});
}

void Supervisor::step_down() {
  replicator_.step_down(replicated());
}

void Supervisor::assign_planners() {
  if (planners_.update(assigned())) publish_mode(turns_.last);  // before the judgement: failover waits for nothing
  turns_.failover_due = planners_.failover_due(assigned());
}

// Samples that arrive while this supervisor listens are history. It judges them once they are complete.
void Supervisor::judge() {
  if (is(Leadership::Role::kListening)) return;
  const Time now = since_epoch(turns_.last);
  if (const auto exit = subscriptions_.take_own_predecessor_exit()) {
    detector_.faults().raise(place_.node,
                             {msg::CauseKind::CAUSE_PROCESS_DIED, msg::Severity::SEVERITY_ERROR, place_.node,
                              place_.node + ": " + end_text(*exit) + "; this process replaced it"},
                             now);
    detector_.faults().clear(place_.node, now);
  }
  detector_.judge(now);
  if (!standing_.due(now)) return;
  for (const std::string& arm : arm_names(file_)) {
    detector_.arm_stands(arm, standing_.update(arm, stands_without_reason(arm, detector_, snapshot_), now));
  }
}

void Supervisor::publish_mode(bus::Clock::time_point now) {
  msg::CellMode decided = mode_message(detector_.mode(), planners_.failover(), place_.node);
  decided.term(leadership_.term());
  decided.lost_arms(lost_arms(file_, stop_without_driver_, detector_, snapshot_, now));
  auto mode = publisher_.next(std::move(decided), now);
  if (!mode) return;
  replicator_.before_publish(replicated(), *mode);
  publisher_.publish(*std::move(mode), now);
}

void Supervisor::publish_faults() {
  if (is(Leadership::Role::kListening)) return;  // changes wait until this supervisor leads
  const auto restored = detector_.faults().take_restored();
  const auto changes = detector_.faults().take_changes();
  if (is(Leadership::Role::kStandingBy) || (restored.empty() && changes.empty())) return;
  replicator_.remember(replicated());
  for (const FaultRecord& record : restored) static_cast<void>(publisher_.publish(record, leadership_.term()));
  for (const FaultRecord& record : changes) log_fault(publisher_.publish(record, leadership_.term()));
}

void Supervisor::answer() {
  const bool leads = is(Leadership::Role::kLeading);
  for (const auto& request : requests_.take(subscriptions_.requests(), leadership_.role())) answer(request);
  if (!leads) requests_.deferred().clear();
  const auto acknowledged = acknowledged_by_standby();
  if (leads && acknowledged) replicator_.standby_acknowledged(replicated(), *acknowledged);
  for (const auto& request : requests_.deferred().take(acknowledged, since_epoch(turns_.last))) reply(request, {});
}

void Supervisor::answer(const msg::SupervisorRequest& request) {
  const msg::Cause refusal = execute(request);
  if (request.kind() == msg::RequestKind::REQUEST_STATUS) return reply(request, refusal);
  log_info("order",
           {{"client", request.client()}, {"kind", static_cast<int>(request.kind())}, {"refused", refusal.text()}});
  if (!is_none(refusal)) return reply(request, refusal);
  if (request.kind() != msg::RequestKind::REQUEST_RESUME) replicator_.ordered(request);
  const auto now = bus::Clock::now();
  publish_mode(now);
  requests_.deferred().add(request, publisher_.mode().sequence_number(), since_epoch(now));
}

msg::Cause Supervisor::execute(const msg::SupervisorRequest& request) {
  switch (request.kind()) {
    case msg::RequestKind::REQUEST_HOLD:
      return detector_.mode().hold(request.arms());
    case msg::RequestKind::REQUEST_RESUME:
      return detector_.mode().resume(request.arms());
    case msg::RequestKind::REQUEST_STOP:
      return detector_.mode().stop(request.arms());
    case msg::RequestKind::REQUEST_SPEED:
      return detector_.mode().set_speed(request.arms(), request.speed());
    case msg::RequestKind::REQUEST_SLOWER:
      return detector_.mode().slow_down(request.arms(), request.speed());
    case msg::RequestKind::REQUEST_STATUS:
      return {};
  }
  return make_cause(msg::CauseKind::CAUSE_INVALID_VALUE, {},
                    "unknown kind of request: use status, hold, resume, stop or speed");
}

void Supervisor::reply(const msg::SupervisorRequest& request, const msg::Cause& refusal) {
  // Before it leads the supervisor publishes no mode; the reply contains the one that it would publish.
  if (is(Leadership::Role::kListening)) {
    publisher_.prepare(mode_message(detector_.mode(), planners_.failover(), place_.node));
  }
  msg::SupervisorReply reply;
  reply.client(request.client());
  reply.request_id(request.request_id());
  reply.done(is_none(refusal));
  reply.cause(refusal);
  if (reply.done() && request.kind() != msg::RequestKind::REQUEST_STATUS) {
    reply.cause(replicator_.persistence_cause(msg::CauseKind::CAUSE_NOT_PERSISTED));
  }
  reply.status(cell_status({file_, detector_, snapshot_, planners_.failover(), publisher_.mode()}, read_clocks()));
  reply.status().uptime(std::chrono::duration<double>(bus::Clock::now() - turns_.began).count());
  publisher_.reply(reply);
}

std::optional<std::uint64_t> Supervisor::acknowledged_by_standby() const {
  for (const PlacedNode& other : place_.supervisors) {
    const auto* heartbeat = other.node == place_.node ? nullptr : find(snapshot_.heartbeats, other.node);
    if (!heartbeat || heartbeat->value.state() != msg::NodeState::NODE_STANDBY || !detector_.alive(other.node))
      continue;
    const msg::ModeNumber& acknowledged = heartbeat->value.acknowledged_mode();
    return acknowledged.term() == leadership_.term() ? acknowledged.sequence_number() : 0;
  }
  return std::nullopt;
}

void Supervisor::publish_heartbeat(bus::Clock::time_point now) {
  HealthReport report;
  report.term = leadership_.term();
  report.acknowledged_mode = subscriptions_.acknowledged_mode();
  report.cause = replicator_.persistence_cause(msg::CauseKind::CAUSE_PERSISTENCE_FAILED);
  switch (leadership_.role()) {
    case Leadership::Role::kListening:
      report.state = msg::NodeState::NODE_STARTING;
      report.cause = make_cause(msg::CauseKind::CAUSE_STARTING, {}, "listens for others before it leads");
      break;
    case Leadership::Role::kStandingBy:
      report.state = msg::NodeState::NODE_STANDBY;
      if (is_none(report.cause)) {
        report.cause =
            make_cause(msg::CauseKind::CAUSE_STANDING_BY, subscriptions_.leader(), "another supervisor leads");
      } else {
        report.cause.text("another supervisor leads; " + report.cause.text());
      }
      break;
    case Leadership::Role::kLeading:
      if (replicator_.persistence_failed()) report.state = msg::NodeState::NODE_DEGRADED;
      break;
  }
  heartbeats_.publisher.publish(now, report, heartbeats_.loop);
}

Replicator::Cell Supervisor::replicated() {
  return {detector_, subscriptions_, publisher_, leadership_.term(), turns_.last};
}

PlannerAssignment::Cell Supervisor::assigned() {
  return {snapshot_, detector_, leadership_, turns_.last};
}

}  // namespace hecaton::services
