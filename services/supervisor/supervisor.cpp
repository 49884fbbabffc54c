#include "services/supervisor/supervisor.hpp"

#include <algorithm>
#include <utility>

#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/supervisor/cell_status.hpp"
#include "services/supervisor/expected_nodes.hpp"
#include "services/supervisor/messages.hpp"

namespace hecaton::services {
namespace {

constexpr std::chrono::minutes kUnknownNodeRemembered{1};
/// Longer than two processes need to find each other on a busy machine.
constexpr std::chrono::seconds kSearch{2};
/// So long after its last turn a process throws away what waits for it (services/bus/absence.hpp).
constexpr std::chrono::milliseconds kStall{250};

SupervisorPlace place_of(const config::CellFile& file, const ServiceOptions& options) {
  SupervisorPlace place{supervisors_of(file), 0, {}, {}};
  place.index = index_on(place.supervisors, options.host);
  const PlacedNode& ours = place.supervisors[place.index];
  place.node = ours.node;
  place.host = options.host.empty() ? ours.host : options.host;
  return place;
}

/// The supervisor that is to stand by when the cell comes up listens longer, so that the other leads.
/// A cell with a long host lease runs where processes wait for a processor: there a leader may be silent longer, too.
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

void TransitionLog::look(const FaultDetector& detector, bus::Clock::time_point now) {
  if (complete_) return;
  const auto& nodes = detector.nodes();
  const auto heard = [&](const ExpectedNode& node) { return detector.silence(node.name).has_value(); };
  if (!first_heard_ && std::any_of(nodes.begin(), nodes.end(), heard)) first_heard_ = now;
  complete_ = first_heard_ && std::all_of(nodes.begin(), nodes.end(), heard);
  if (!complete_) return;
  const auto since = [&](bus::Clock::time_point at) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(now - at).count();
  };
  log_info("supervisor knows everybody",
           {{"nodes", nodes.size()}, {"after_ms", since(*first_heard_)}, {"after_matching_ms", since(newest_match_)}});
}

Supervisor::Connection::Connection(const config::CellFile& file, const ServiceOptions& options, const std::string& node)
    : participant(make_participant(file, options, node, &quiet)) {}

Supervisor::Supervisor(const config::CellFile& file, const ServiceOptions& options, ShutdownSignal& shutdown)
    : file_(file),
      place_(place_of(file, options)),
      shutdown_(shutdown),
      turns_{bus::Clock::now(), bus::Clock::now()},
      detector_(expected_nodes(file, place_.node), arm_names(file), detection_limits(file, kTurn),
                since_epoch(turns_.began), place_.host),
      replicator_(place_.node, options.memory, place_.supervisors.size() == 1),
      planners_(arms_with_standby(file), {file.supervision.takeover_lease, file.supervision.host_lease}, turns_.began),
      requests_(place_.supervisors.size() == 1),
      connection_(file, options, place_.node),
      subscriptions_(connection_.participant, {place_.node, place_.host, replicator_.checkpoint().term > 0},
                     connection_.urgent, connection_.quiet),
      leadership_(leadership_limits(place_, file.supervision.host_lease), replicator_.checkpoint().term,
                  since_epoch(bus::Clock::now()), {place_.index, place_.supervisors.size()}),
      publisher_(connection_.participant, place_.node),
      heart_{Pulse(connection_.participant, {place_.node, msg::NodeKind::NODE_SUPERVISOR, {}, place_.host},
                   pulse_timing(file, options)),
             {}} {
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
    const auto until = std::min(deadline, turns_.takeover_due);
    static_cast<void>(connection_.urgent.wait(std::max(until - bus::Clock::now(), bus::Clock::duration::zero())));
    const auto now = bus::Clock::now();
    if (now >= deadline) {
      const NextDeadline next = next_deadline(deadline, now, kTurn);
      heart_.loop.record_lateness(std::max(now - deadline, bus::Clock::duration::zero()), next.skipped);
      deadline = next.at;
    }
    turn(now);
    heart_.loop.record_tick(bus::Clock::now() - now);
  }
  log_info("supervisor ends", {{"term", leadership_.term()}});
}

void Supervisor::turn(bus::Clock::time_point now) {
  if (!is_present(now)) return;
  const auto last_turn = std::exchange(turns_.last, now);
  const bool led = is(Leadership::Role::kLeading);
  receive(now);
  decide_leadership(led, last_turn);
  if (is(Leadership::Role::kStandingBy)) replicator_.follow(replicated());
  assign_planners();
  judge();
  if (is(Leadership::Role::kLeading)) publish_mode(now);
  publish_faults();
  answer();
  transitions_.look(detector_, now);
  if (heart_.pulse.due(now, kTurn / 2)) beat(now);
}

// A supervisor that was stopped blames no node for the silence. It listens again before it leads, with a new term.
bool Supervisor::is_present(bus::Clock::time_point now) {
  if (connection_.participant.away()) {
    if (!turns_.absent_since) turns_.absent_since = turns_.last;
    turns_.takeover_due = bus::Clock::time_point::max();  // or the loop would not wait
    return false;
  }
  if (turns_.absent_since) {
    leadership_.absent(since_epoch(now));
    stand_back();
    report_own_silence("was itself stopped and away", *std::exchange(turns_.absent_since, std::nullopt));
  }
  return true;
}

void Supervisor::receive(bus::Clock::time_point now) {
  // The clock first, so that no node is blamed for a silence that ends with what is already here.
  detector_.advance(since_epoch(now));
  for (const bus::Event& event : connection_.quiet.take_events()) {
    if (event.kind == bus::EventKind::kPeerMatched) transitions_.matched(event.at);
  }
  static_cast<void>(connection_.urgent.take_events());
  subscriptions_.listen(publisher_.id(), {snapshot_, detector_, leadership_, planners_.failover()});
  std::erase_if(snapshot_.heartbeats, [&](const auto& entry) {
    return !detector_.expects(entry.first) && now - entry.second.at > kUnknownNodeRemembered;
  });
}

void Supervisor::decide_leadership(bool led, bus::Clock::time_point last_turn) {
  const bool replaced = led && !is(Leadership::Role::kLeading);
  if (replaced) {
    log_warning("another supervisor leads", {{"own_term", leadership_.term()}});
    stand_back();  // before the next decision: what the other may not have would be lost if we led again in this turn
  }
  // A leader whose host hears no other host knows nothing of the cell, and no order reaches it.
  const auto& leader = subscriptions_.other_mode();
  if (leader && detector_.is_isolated(leader->node())) leadership_.leader_died();
  if (leadership_.decide(since_epoch(turns_.last), subscriptions_.newest_arrival())) {
    replicator_.begin_to_lead(replicated());
    publisher_.begin_to_lead(leadership_.term());
    log_info("supervisor leads", {{"term", leadership_.term()}});
  }
  // A leader that goes on reports its own stall: a standby that saw it publishes nothing.
  const bool goes_on = led && !replaced;
  if (goes_on && turns_.last - last_turn > std::max<Time>(file_.supervision.heartbeat_deadline, kStall)) {
    report_own_silence("stood still", last_turn);
  }
}

void Supervisor::report_own_silence(const std::string& what, bus::Clock::time_point since) {
  const auto now = bus::Clock::now();
  const auto silence = std::chrono::duration_cast<std::chrono::milliseconds>(now - since);
  detector_.faults().raise(place_.node,
                           {msg::CauseKind::CAUSE_NODE_SILENT, msg::Severity::SEVERITY_ERROR, place_.node,
                            place_.node + ": " + what + " for " + std::to_string(silence.count()) +
                                " ms; faults of that time may not have been seen",
                            silence},
                           since_epoch(since));
  detector_.faults().clear(place_.node, since_epoch(now));
  log_warning("supervisor " + what, {{"ms", silence.count()}});
}

// A driver that starts now must not follow what we granted: it has no memory of what was granted since.
void Supervisor::stand_back() {
  publisher_.withdraw_mode();
  replicator_.stand_back(replicated());
}

void Supervisor::assign_planners() {
  if (planners_.update(assigned())) publish_mode(turns_.last);  // before the judgement: a takeover waits for nothing
  turns_.takeover_due = planners_.takeover_due(assigned());
}

// What arrives while we listen is history: it is judged once it is complete.
void Supervisor::judge() {
  if (is(Leadership::Role::kListening)) return;
  const Time now = since_epoch(turns_.last);
  if (const auto exit = subscriptions_.take_predecessor()) {
    detector_.faults().raise(place_.node,
                             {msg::CauseKind::CAUSE_PROCESS_DIED, msg::Severity::SEVERITY_ERROR, place_.node,
                              place_.node + ": " + end_text(*exit) + "; this one took its place"},
                             now);
    detector_.faults().clear(place_.node, now);
  }
  detector_.judge(now);
}

void Supervisor::publish_mode(bus::Clock::time_point now) {
  msg::CellMode decided = mode_message(detector_.mode(), planners_.failover(), place_.node);
  decided.term(leadership_.term());
  decided.lost_arms(lost_arms(file_, detector_, snapshot_, now));
  auto mode = publisher_.next(std::move(decided), now);
  if (!mode) return;
  replicator_.about_to_publish(replicated(), *mode);
  publisher_.publish(*std::move(mode), now);
}

void Supervisor::publish_faults() {
  if (is(Leadership::Role::kListening)) return;  // they wait until we lead
  const auto recalled = detector_.faults().take_recalled();
  const auto changes = detector_.faults().take_changes();
  if (is(Leadership::Role::kStandingBy) || (recalled.empty() && changes.empty())) return;
  replicator_.remember(replicated());
  for (const FaultRecord& record : recalled) static_cast<void>(publisher_.publish(record, leadership_.term()));
  for (const FaultRecord& record : changes) log_fault(publisher_.publish(record, leadership_.term()));
}

void Supervisor::answer() {
  const bool leads = is(Leadership::Role::kLeading);
  for (const auto& request : requests_.take(subscriptions_.requests(), leadership_.role())) answer(request);
  if (!leads) requests_.deferred().drop();
  const auto received = received_by_standby();
  if (leads && received) replicator_.standby_received(replicated(), *received);
  for (const auto& request : requests_.deferred().take(received, since_epoch(turns_.last))) reply(request, {});
}

void Supervisor::answer(const msg::SupervisorRequest& request) {
  const msg::Cause refusal = obey(request);
  if (request.kind() == msg::RequestKind::REQUEST_STATUS) return reply(request, refusal);
  log_info("order",
           {{"client", request.client()}, {"kind", static_cast<int>(request.kind())}, {"refused", refusal.text()}});
  if (!is_none(refusal)) return reply(request, refusal);
  if (request.kind() != msg::RequestKind::REQUEST_RESUME) replicator_.ordered(request);
  const auto now = bus::Clock::now();
  publish_mode(now);
  requests_.deferred().owe(request, publisher_.mode().sequence_number(), since_epoch(now));
}

msg::Cause Supervisor::obey(const msg::SupervisorRequest& request) {
  switch (request.kind()) {
    case msg::RequestKind::REQUEST_HOLD:
      return detector_.mode().hold(request.arms());
    case msg::RequestKind::REQUEST_RESUME:
      return detector_.mode().resume(request.arms());
    case msg::RequestKind::REQUEST_STOP:
      return detector_.mode().stop(request.arms());
    case msg::RequestKind::REQUEST_STATUS:
      return {};
  }
  return make_cause(msg::CauseKind::CAUSE_INVALID_VALUE, {},
                    "unknown kind of request: status, hold, resume and stop are allowed");
}

void Supervisor::reply(const msg::SupervisorRequest& request, const msg::Cause& refusal) {
  // Before we lead nothing is published yet; what will be is answered all the same.
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

std::optional<std::uint64_t> Supervisor::received_by_standby() const {
  for (const PlacedNode& other : place_.supervisors) {
    const auto* beat = other.node == place_.node ? nullptr : find(snapshot_.heartbeats, other.node);
    if (!beat || beat->value.state() != msg::NodeState::NODE_STANDBY || !detector_.alive(other.node)) continue;
    const msg::ModeNumber& heard = beat->value.heard_mode();
    return heard.term() == leadership_.term() ? heard.sequence_number() : 0;
  }
  return std::nullopt;
}

void Supervisor::beat(bus::Clock::time_point now) {
  Vital vital;
  vital.term = leadership_.term();
  vital.heard_mode = subscriptions_.newest_mode_of_others();
  vital.cause = replicator_.persistence_cause(msg::CauseKind::CAUSE_PERSISTENCE_FAILED);
  switch (leadership_.role()) {
    case Leadership::Role::kListening:
      vital.state = msg::NodeState::NODE_STARTING;
      vital.cause = make_cause(msg::CauseKind::CAUSE_STARTING, {}, "listens for others before it leads");
      break;
    case Leadership::Role::kStandingBy:
      vital.state = msg::NodeState::NODE_STANDBY;
      if (is_none(vital.cause)) {
        vital.cause =
            make_cause(msg::CauseKind::CAUSE_STANDING_BY, subscriptions_.leader(), "another supervisor leads");
      } else {
        vital.cause.text("another supervisor leads; " + vital.cause.text());
      }
      break;
    case Leadership::Role::kLeading:
      if (replicator_.persistence_failed()) vital.state = msg::NodeState::NODE_DEGRADED;
      break;
  }
  heart_.pulse.beat(now, vital, heart_.loop);
}

Replicator::Cell Supervisor::replicated() {
  return {detector_, subscriptions_, publisher_, leadership_.term(), turns_.last};
}

PlannerAssignment::Cell Supervisor::assigned() {
  return {snapshot_, detector_, leadership_, turns_.last};
}

}  // namespace hecaton::services
