#include "services/supervisor/supervisor.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/process_info.hpp"
#include "services/supervisor/cell_status.hpp"
#include "services/supervisor/expected_nodes.hpp"

namespace hecaton::services {
namespace {

constexpr std::chrono::minutes kStrangerRemembered{1};

Time since_epoch(bus::Clock::time_point at) {
  return at.time_since_epoch();
}

Memory recall(const std::string& path) {
  if (path.empty()) return {};
  return read_memory(path).value_or(Memory{});
}

/// What another leader's mode tells of people's orders: only people stop.
Orders orders_in(const msg::CellMode& mode) {
  Orders orders;
  if (mode.mode() == msg::MODE_STOP) orders.cell = MoveMode::kStop;
  for (const std::string& arm : mode.stopped_arms()) orders.arms[arm] = MoveMode::kStop;
  return orders;
}

bool same_decision(const msg::CellMode& a, const msg::CellMode& b) {
  return a.term() == b.term() && a.mode() == b.mode() && a.held_arms() == b.held_arms() &&
         a.stopped_arms() == b.stopped_arms() && a.reason() == b.reason();
}

void log_fault(const msg::Fault& fault) {
  const LogFields fields{
      {"id", fault.id()}, {"kind", fault.kind()}, {"subject", fault.subject()}, {"seen", fault.seen()}};
  if (fault.cleared()) {
    log_info("fault cleared", fields);
  } else {
    log_warning("fault", fields);
  }
}

}  // namespace

Supervisor::Supervisor(const config::CellFile& file, const ServiceOptions& options, ShutdownSignal& shutdown)
    : file_(file),
      memory_path_(options.memory),
      shutdown_(shutdown),
      began_(bus::Clock::now()),
      watch_(expected_nodes(file), arm_names(file), watch_limits(file, kTurn), since_epoch(began_)),
      remembered_(recall(memory_path_)),
      leadership_({}, remembered_.term, since_epoch(began_)),
      turned_(began_),
      participant_(make_participant(file, options, supervisor_node(), &quiet_)),
      ears_(participant_, urgent_, quiet_),
      modes_(participant_),
      faults_(participant_),
      replies_(participant_),
      pulse_(participant_,
             {supervisor_node(), msg::NODE_SUPERVISOR, {}, options.host.empty() ? file.supervision.host : options.host},
             pulse_timing(file)) {
  watch_.mode().restore(remembered_.orders);
  watch_.faults().recall(remembered_.faults);
  shutdown_.wake(&urgent_);
}

Supervisor::~Supervisor() {
  shutdown_.wake(nullptr);
}

void Supervisor::run() {
  log_info("supervisor started", {{"cell", file_.cell.name}, {"remembered_term", remembered_.term}});
  auto deadline = bus::Clock::now();
  while (!shutdown_.requested()) {
    const bool woken = urgent_.wait(std::max(deadline - bus::Clock::now(), bus::Clock::duration::zero()));
    const auto now = bus::Clock::now();
    if (!woken || now >= deadline) {
      const NextDeadline next = next_deadline(deadline, now, kTurn);
      loop_.record_lateness(std::max(now - deadline, bus::Clock::duration::zero()), next.skipped);
      deadline = next.at;
    }
    turn(now);
    loop_.record_tick(bus::Clock::now() - now);
  }
  log_info("supervisor ends", {{"term", leadership_.term()}});
}

void Supervisor::turn(bus::Clock::time_point now) {
  if (participant_.away()) {
    if (!absent_since_) absent_since_ = turned_;
    return;
  }
  if (absent_since_) come_back(now);
  turned_ = now;
  // Before listening, so that nobody is accused of a silence that ends with what is already here.
  watch_.advance(since_epoch(now));
  static_cast<void>(quiet_.take_events());
  static_cast<void>(urgent_.take_events());
  ears_.listen(modes_.id(), picture_, watch_, leadership_);
  const Time stalled = watch_.clock().stalled() - std::exchange(stalled_, watch_.clock().stalled());
  const bool led = leadership_.role() == Leadership::Role::kLeading;
  if (leadership_.decide(since_epoch(now), stalled)) begin_to_lead();
  const bool leads = leadership_.role() == Leadership::Role::kLeading;
  if (led && !leads) log_warning("another supervisor leads", {{"own_term", leadership_.term()}});
  // What is told while we listen is history: it is judged once it is complete.
  if (leadership_.role() != Leadership::Role::kListening) {
    tell_predecessor(since_epoch(now));
    watch_.judge(since_epoch(now));
  }
  if (leads) publish_mode(now);
  publish_faults();
  for (const auto& sample : ears_.requests()) {
    if (leadership_.role() != Leadership::Role::kStandingBy && !sample.disposed) answer(sample.value);
  }
  forget_strangers(now);
  if (pulse_.due(now)) beat(now);
}

// Who was stopped accuses nobody of the silence. It listens again before it leads, with a new term.
void Supervisor::come_back(bus::Clock::time_point now) {
  leadership_.absent(since_epoch(now));
  const auto absence = std::chrono::duration_cast<std::chrono::milliseconds>(now - *absent_since_);
  const Time since = since_epoch(*absent_since_);
  absent_since_.reset();
  watch_.faults().raise(supervisor_node(),
                        {FaultKind::kNodeSilent, FaultSeverity::kError, supervisor_node(),
                         supervisor_node() + ": was itself stopped and away for " + std::to_string(absence.count()) +
                             " ms; faults of that time were not seen"},
                        since);
  watch_.faults().clear(supervisor_node(), since_epoch(now));
  log_warning("supervisor was away", {{"ms", absence.count()}});
}

void Supervisor::begin_to_lead() {
  // After another leader its orders hold; after our own earlier life those that we remember.
  const auto other = ears_.take_other_mode();
  if (std::exchange(led_before_, true) && other) watch_.mode().restore(orders_in(*other));
  watch_.faults().begin_life(leadership_.term());
  constexpr auto kStrongest = static_cast<std::uint64_t>(std::numeric_limits<int>::max());
  modes_.set_strength(static_cast<int>(std::min(leadership_.term(), kStrongest)));
  log_info("supervisor leads", {{"term", leadership_.term()}});
}

void Supervisor::tell_predecessor(Time now) {
  const auto exit = ears_.take_predecessor();
  if (!exit) return;
  watch_.faults().raise(supervisor_node(),
                        {FaultKind::kProcessDied, FaultSeverity::kError, supervisor_node(),
                         supervisor_node() + ": " + end_text(*exit) + "; this one took its place"},
                        now);
  watch_.faults().clear(supervisor_node(), now);
}

std::string Supervisor::obey(const msg::SupervisorRequest& request) {
  switch (request.kind()) {
    case msg::REQUEST_HOLD:
      return watch_.mode().hold(request.arms());
    case msg::REQUEST_RESUME:
      return watch_.mode().resume(request.arms());
    case msg::REQUEST_STOP:
      return watch_.mode().stop(request.arms());
    case msg::REQUEST_STATUS:
      return {};
  }
  return "unknown kind of request: status, hold, resume and stop are allowed";
}

void Supervisor::answer(const msg::SupervisorRequest& request) {
  const std::string refusal = obey(request);
  const auto now = bus::Clock::now();
  if (request.kind() != msg::REQUEST_STATUS) {
    log_info("order", {{"client", request.client()}, {"kind", static_cast<int>(request.kind())}, {"refused", refusal}});
    if (leadership_.role() == Leadership::Role::kLeading) publish_mode(now);
  }
  // Before we lead nothing is published yet; what will be is answered all the same.
  if (leadership_.role() == Leadership::Role::kListening) {
    mode_ = mode_message(watch_.mode().decide(), supervisor_node());
  }
  msg::SupervisorReply reply;
  reply.client(request.client());
  reply.request_id(request.request_id());
  reply.done(refusal.empty());
  reply.reason(refusal);
  reply.status(cell_status({file_, watch_, picture_, mode_}, read_clocks()));
  reply.status().supervisor(supervisor_node());
  reply.status().uptime(std::chrono::duration<double>(now - began_).count());
  static_cast<void>(replies_.write(reply));  // the bus has logged a refusal
}

void Supervisor::publish_mode(bus::Clock::time_point now) {
  msg::CellMode next = mode_message(watch_.mode().decide(), supervisor_node());
  next.term(leadership_.term());
  const bool changed = !same_decision(next, mode_);
  if (!changed && now - mode_at_ < kRepeat) return;
  // Remembered before it is published: an order that somebody has seen is never forgotten.
  remember();
  next.sequence_number(mode_.sequence_number() + 1);
  next.stamp_ns(stamp_now());
  mode_ = std::move(next);
  mode_at_ = now;
  static_cast<void>(modes_.write(mode_));
  if (changed) {
    log_info("cell mode", {{"mode", mode_name(watch_.mode().decide().cell)}, {"reason", mode_.reason()}});
  }
}

void Supervisor::remember() {
  Memory memory{leadership_.term(), watch_.mode().orders(), watch_.faults().history()};
  if (memory_path_.empty() || memory == remembered_) return;
  if (!write_memory(memory_path_, memory)) log_error("orders cannot be remembered", {{"file", memory_path_}});
  remembered_ = std::move(memory);
}

void Supervisor::publish_faults() {
  if (leadership_.role() == Leadership::Role::kListening) return;  // they wait until we lead
  if (leadership_.role() == Leadership::Role::kStandingBy) {
    static_cast<void>(watch_.faults().take_changes());
    return;
  }
  const auto changes = watch_.faults().take_changes();
  if (changes.empty()) return;
  remember();
  const Clocks clocks = read_clocks();
  for (const FaultRecord& record : changes) {
    msg::Fault fault = fault_message(record, clocks);
    fault.term(leadership_.term());
    fault.sequence_number(++fault_sequence_);
    fault.stamp_ns(stamp_now());
    static_cast<void>(faults_.write(fault));
    log_fault(fault);
  }
}

void Supervisor::forget_strangers(bus::Clock::time_point now) {
  std::erase_if(picture_.heartbeats, [&](const auto& entry) {
    return !watch_.expects(entry.first) && now - entry.second.at > kStrangerRemembered;
  });
}

void Supervisor::beat(bus::Clock::time_point now) {
  Vital vital;
  vital.term = leadership_.term();
  switch (leadership_.role()) {
    case Leadership::Role::kListening:
      vital.state = msg::NODE_STARTING;
      vital.detail = "listens for others before it leads";
      break;
    case Leadership::Role::kStandingBy:
      vital.state = msg::NODE_STANDBY;
      vital.detail = "another supervisor leads";
      break;
    case Leadership::Role::kLeading:
      break;
  }
  pulse_.beat(now, vital, loop_);
}

}  // namespace hecaton::services
