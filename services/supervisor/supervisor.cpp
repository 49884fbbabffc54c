#include "services/supervisor/supervisor.hpp"

#include <algorithm>
#include <utility>

#include "planner/trajectory/stop_profile.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/process_info.hpp"
#include "services/supervisor/cell_status.hpp"
#include "services/supervisor/expected_nodes.hpp"
#include "services/supervisor/messages.hpp"

namespace hecaton::services {
namespace {

constexpr std::chrono::minutes kStrangerRemembered{1};

bool same_decision(const msg::CellMode& a, const msg::CellMode& b) {
  return a.term() == b.term() && a.mode() == b.mode() && a.held_arms() == b.held_arms() &&
         a.stopped_arms() == b.stopped_arms() && a.reason() == b.reason() && a.ordered() == b.ordered() &&
         a.arms_ordered_to_hold() == b.arms_ordered_to_hold() && a.grants() == b.grants() &&
         a.lost_arms() == b.lost_arms();
}

/// Longer than two processes need to find each other on a busy machine.
constexpr std::chrono::seconds kSearch{2};

/// Who is to stand by when the cell comes up listens longer, so that the other leads.
Leadership::Limits patience_of(std::size_t place, std::size_t supervisors) {
  Leadership::Limits limits;
  limits.listen *= static_cast<int>(place) + 1;
  limits.search = supervisors > 1 ? kSearch + limits.listen : limits.listen;
  return limits;
}

std::string own_host(const ServiceOptions& options, const PlacedNode& place) {
  return options.host.empty() ? place.host : options.host;
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
      supervisors_(supervisors_of(file)),
      place_(index_on(supervisors_, options.host)),
      node_(supervisors_[place_].node),
      shutdown_(shutdown),
      began_(bus::Clock::now()),
      watch_(expected_nodes(file, node_), arm_names(file), detection_limits(file, kTurn), since_epoch(began_),
             own_host(options, supervisors_[place_])),
      memory_(options.memory),
      succession_(arms_with_standby(file)),
      led_under_(memory_.kept().term),
      turned_(began_),
      order_legacy_(memory_.kept().unheard),
      participant_(make_participant(file, options, node_, &quiet_)),
      ears_(participant_, {node_, own_host(options, supervisors_[place_]), memory_.kept().term > 0}, urgent_, quiet_),
      leadership_(patience_of(place_, supervisors_.size()), memory_.kept().term, since_epoch(bus::Clock::now()),
                  {place_, supervisors_.size()}),
      modes_(participant_),
      faults_(participant_),
      replies_(participant_),
      requests_(participant_),
      pulse_(participant_, {node_, msg::NodeKind::NODE_SUPERVISOR, {}, own_host(options, supervisors_[place_])},
             pulse_timing(file, options)) {
  for (const ArmPlanners& arm : succession_.arms()) {
    patience_.emplace(arm.arm, TakeoverPatience(file.supervision.takeover_lease, file.supervision.host_lease));
  }
  const Memory& kept = memory_.kept();
  watch_.mode().restore(kept.orders, kept.causes);
  watch_.faults().recall(kept.faults);
  legacy_.leave(kept.faults, kept.term);
  shutdown_.wake(&urgent_);
}

Supervisor::~Supervisor() {
  shutdown_.wake(nullptr);
}

void Supervisor::run() {
  log_info("supervisor started", {{"cell", file_.cell.name}, {"remembered_term", memory_.kept().term}});
  auto deadline = bus::Clock::now();
  while (!shutdown_.requested()) {
    const auto until = std::min(deadline, takeover_due_);
    static_cast<void>(urgent_.wait(std::max(until - bus::Clock::now(), bus::Clock::duration::zero())));
    const auto now = bus::Clock::now();
    if (now >= deadline) {
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
    takeover_due_ = bus::Clock::time_point::max();  // or the loop would not wait
    return;
  }
  if (absent_since_) come_back(now);
  const auto last_turn = std::exchange(turned_, now);
  // Before listening, so that nobody is accused of a silence that ends with what is already here.
  watch_.advance(since_epoch(now));
  for (const bus::Event& event : quiet_.take_events()) {
    if (!acquainted_ && event.kind == bus::EventKind::kPeerMatched) newest_match_ = event.at;
  }
  static_cast<void>(urgent_.take_events());
  const bool led = leadership_.role() == Leadership::Role::kLeading;
  ears_.listen(modes_.id(), {picture_, watch_, leadership_, succession_});  // may end it
  if (!acquainted_) get_acquainted();
  const auto& leader = ears_.other_mode();
  // A leader whose host hears no other host knows nothing of the cell, and nobody's orders reach it.
  if (leader && watch_.is_isolated(leader->node())) leadership_.leader_died();
  if (leadership_.decide(since_epoch(now), ears_.newest_arrival())) begin_to_lead();
  const bool leads = leadership_.role() == Leadership::Role::kLeading;
  if (led && !leads) {
    log_warning("another supervisor leads", {{"own_term", leadership_.term()}});
    withdraw();
  }
  if (led && leads) tell_stall(last_turn, now);
  if (leadership_.role() == Leadership::Role::kStandingBy) {
    settle_legacy();
    hand_over_orders();
    remember_leader();  // before our heartbeat says that we have heard it
  }
  if (settle_succession()) publish_mode(now);  // at once: all the rest can wait
  takeover_due_ = takeover_due(now);
  // What is told while we listen is history: it is judged once it is complete.
  if (leadership_.role() != Leadership::Role::kListening) {
    tell_predecessor(since_epoch(now));
    watch_.judge(since_epoch(now));
  }
  if (leads) publish_mode(now);
  publish_faults();
  answer_requests();
  if (!leads) owed_.drop();
  const auto heard = heard_by_standby();
  // Remembered before it is acknowledged: in a next life we would order once more what people have resumed since.
  if (leads && heard && order_legacy_.heard(*heard)) remember();
  for (const auto& request : owed_.take(heard, since_epoch(now))) reply(request, {});
  forget_strangers(now);
  if (pulse_.due(now, kTurn / 2)) beat(now);
}

void Supervisor::answer_requests() {
  const Leadership::Role role = leadership_.role();
  if (role == Leadership::Role::kStandingBy) early_.clear();
  if (role == Leadership::Role::kLeading) {
    for (const auto& request : std::exchange(early_, {})) answer(request);
  }
  for (auto& sample : ears_.requests()) {
    if (!answers() || sample.disposed) continue;
    if (role == Leadership::Role::kLeading || sample.value.kind() == msg::RequestKind::REQUEST_STATUS) {
      answer(sample.value);
    } else {
      early_.push_back(std::move(sample.value));
    }
  }
}

// Who listens before it leads answers, too, unless another may lead meanwhile.
bool Supervisor::answers() const {
  const bool listens = leadership_.role() == Leadership::Role::kListening && supervisors_.size() == 1;
  return listens || leadership_.role() == Leadership::Role::kLeading;
}

void Supervisor::get_acquainted() {
  const auto& nodes = watch_.nodes();
  const auto heard = [this](const ExpectedNode& node) { return watch_.silence(node.name).has_value(); };
  if (!first_word_ && std::any_of(nodes.begin(), nodes.end(), heard)) first_word_ = turned_;
  acquainted_ = first_word_ && std::all_of(nodes.begin(), nodes.end(), heard);
  if (!acquainted_) return;
  const auto since = [this](bus::Clock::time_point at) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(turned_ - at).count();
  };
  log_info("supervisor knows everybody",
           {{"nodes", nodes.size()}, {"after_ms", since(*first_word_)}, {"after_matching_ms", since(newest_match_)}});
}

bool Supervisor::settle_succession() {
  const bool leads = leadership_.role() == Leadership::Role::kLeading;
  const auto fitness = [&](const std::string& arm, const std::string& planner) {
    return fitness_of(signs_of(arm, planner), {patience_with(arm), file_.supervision.host_lease});
  };
  const bool granted = leads && succession_.decide(fitness, leadership_);
  for (const ArmPlanners& arm : succession_.arms()) {
    const Mandate mandate = succession_.mandate_of(arm.arm);
    const std::string before = watch_.in_charge(arm.arm);
    if (mandate.planner.empty() || mandate.planner == before) continue;
    if (granted && !watch_.ended(before)) patience_.at(arm.arm).replaced(since_epoch(turned_));
    watch_.put_in_charge(arm.arm, mandate.planner);
    in_charge_since_[arm.arm] = turned_;
    log_info("planner in charge", {{"arm", arm.arm}, {"planner", mandate.planner}, {"term", mandate.term}});
  }
  return granted;
}

Time Supervisor::patience_with(const std::string& arm) const {
  return patience_.at(arm).at(since_epoch(turned_));
}

PlannerSigns Supervisor::signs_of(const std::string& arm, const std::string& planner) const {
  const auto* beat = find(picture_.heartbeats, planner);
  PlannerSigns signs;
  signs.ended = watch_.ended(planner);
  signs.silence = watch_.silence(planner);
  signs.stands_by = beat && beat->value.state() == msg::NodeState::NODE_STANDBY;
  if (planner != watch_.in_charge(arm)) return signs;
  const auto since = in_charge_since_.find(arm);
  signs.in_charge = turned_ - (since == in_charge_since_.end() ? began_ : since->second);
  const auto* state = find(picture_.arms, arm);
  if (!state || state->value.term() == 0 || turned_ - state->at >= patience_with(arm)) return signs;
  const std::chrono::duration<double> uncommanded(state->value.command_age() + state->age(turned_));
  signs.uncommanded = std::chrono::duration_cast<Time>(uncommanded);
  return signs;
}

bus::Clock::time_point Supervisor::takeover_due(bus::Clock::time_point now) const {
  auto due = bus::Clock::time_point::max();
  for (const ArmPlanners& arm : succession_.arms()) {
    const PlannerSigns signs = signs_of(arm.arm, watch_.in_charge(arm.arm));
    if (!signs.silence) continue;
    const Time silence = std::min(*signs.silence, signs.uncommanded.value_or(*signs.silence));
    const Time left = patience_with(arm.arm) - silence;
    if (left > Time(0)) due = std::min(due, now + left);
  }
  return due;
}

void Supervisor::tell_predecessor(Time now) {
  const auto exit = ears_.take_predecessor();
  if (!exit) return;
  watch_.faults().raise(node_,
                        {FaultKind::kProcessDied, FaultSeverity::kError, node_,
                         node_ + ": " + end_text(*exit) + "; this one took its place"},
                        now);
  watch_.faults().clear(node_, now);
}

std::string Supervisor::obey(const msg::SupervisorRequest& request) {
  switch (request.kind()) {
    case msg::RequestKind::REQUEST_HOLD:
      return watch_.mode().hold(request.arms());
    case msg::RequestKind::REQUEST_RESUME:
      return watch_.mode().resume(request.arms());
    case msg::RequestKind::REQUEST_STOP:
      return watch_.mode().stop(request.arms());
    case msg::RequestKind::REQUEST_STATUS:
      return {};
  }
  return "unknown kind of request: status, hold, resume and stop are allowed";
}

void Supervisor::answer(const msg::SupervisorRequest& request) {
  const std::string refusal = obey(request);
  if (request.kind() == msg::RequestKind::REQUEST_STATUS) return reply(request, refusal);
  log_info("order", {{"client", request.client()}, {"kind", static_cast<int>(request.kind())}, {"refused", refusal}});
  if (!refusal.empty()) return reply(request, refusal);
  if (request.kind() != msg::RequestKind::REQUEST_RESUME) order_legacy_.given(request.arms());
  const auto now = bus::Clock::now();
  publish_mode(now);
  owed_.owe(request, mode_.sequence_number(), since_epoch(now));
}

std::optional<std::uint64_t> Supervisor::heard_by_standby() const {
  for (const PlacedNode& other : supervisors_) {
    const auto* beat = other.node == node_ ? nullptr : find(picture_.heartbeats, other.node);
    if (!beat || beat->value.state() != msg::NodeState::NODE_STANDBY || !watch_.alive(other.node)) continue;
    const msg::ModeNumber& heard = beat->value.heard_mode();
    return heard.term() == leadership_.term() ? heard.sequence_number() : 0;
  }
  return std::nullopt;
}

void Supervisor::reply(const msg::SupervisorRequest& request, const std::string& refusal) {
  const auto now = bus::Clock::now();
  // Before we lead nothing is published yet; what will be is answered all the same.
  if (leadership_.role() == Leadership::Role::kListening) {
    mode_ = mode_message(watch_.mode(), succession_, node_);
  }
  msg::SupervisorReply reply;
  reply.client(request.client());
  reply.request_id(request.request_id());
  reply.done(refusal.empty());
  reply.reason(refusal.empty() && request.kind() != msg::RequestKind::REQUEST_STATUS ? memory_.failure() : refusal);
  reply.status(cell_status({file_, watch_, picture_, succession_, mode_}, read_clocks()));
  reply.status().uptime(std::chrono::duration<double>(now - began_).count());
  static_cast<void>(replies_.write(reply));  // the bus has logged a refusal
}

// Told only once they are at rest, so that nobody has to count how long ago they were lost.
std::vector<msg::LostArm> Supervisor::lost_arms(bus::Clock::time_point now) const {
  std::vector<msg::LostArm> lost;
  for (const planner::PlannedArm& planned : file_.cell.arms) {
    const Loss loss = watch_.loss_of(planned.arm.name);
    const auto* last = find(picture_.arms, planned.arm.name);
    if (loss == Loss::kNone || !last) continue;
    const double moved_for = loss == Loss::kEnded ? longest_motion_of_dead(file_) : longest_motion_of_cut_off(file_);
    if (last->age(now) < moved_for + planner::longest_stop_time(planned.arm.limits)) continue;
    msg::LostArm& arm = lost.emplace_back();
    arm.arm(planned.arm.name);
    arm.stamp_ns(last->value.stamp_ns());
    arm.q(last->value.q());
    arm.qd(last->value.qd());
    arm.moved_for(moved_for);
  }
  return lost;
}

void Supervisor::publish_mode(bus::Clock::time_point now) {
  msg::CellMode next = mode_message(watch_.mode(), succession_, node_);
  next.term(leadership_.term());
  next.lost_arms(lost_arms(now));
  const bool changed = !same_decision(next, mode_);
  if (!changed && now - mode_at_ < kRepeat) return;
  next.sequence_number(mode_.sequence_number() + 1);
  order_legacy_.published(watch_.mode().orders(), next.sequence_number());
  // Remembered before it is published: an order that somebody has seen is never forgotten.
  remember();
  next.stamp_ns(stamp_now());
  mode_ = std::move(next);
  mode_at_ = now;
  static_cast<void>(modes_.write(mode_));
  if (changed) {
    log_info("cell mode", {{"mode", mode_name(watch_.mode().decide().cell)}, {"reason", mode_.reason()}});
  }
}

void Supervisor::publish_faults() {
  if (leadership_.role() == Leadership::Role::kListening) return;  // they wait until we lead
  if (leadership_.role() == Leadership::Role::kStandingBy) {
    static_cast<void>(watch_.faults().take_recalled());
    static_cast<void>(watch_.faults().take_changes());
    return;
  }
  const auto recalled = watch_.faults().take_recalled();
  const auto changes = watch_.faults().take_changes();
  if (recalled.empty() && changes.empty()) return;
  remember();
  const Clocks clocks = read_clocks();
  for (const FaultRecord& record : recalled) publish_fault(record, leadership_.term(), clocks);
  for (const FaultRecord& record : changes) log_fault(publish_fault(record, leadership_.term(), clocks));
}

msg::Fault Supervisor::publish_fault(const FaultRecord& record, std::uint64_t term, const Clocks& clocks) {
  msg::Fault fault = fault_message(record, clocks);
  fault.term(term);
  fault.sequence_number(++fault_sequence_);
  fault.stamp_ns(stamp_now());
  static_cast<void>(faults_.write(fault));
  return fault;
}

void Supervisor::forget_strangers(bus::Clock::time_point now) {
  std::erase_if(picture_.heartbeats, [&](const auto& entry) {
    return !watch_.expects(entry.first) && now - entry.second.at > kStrangerRemembered;
  });
}

void Supervisor::beat(bus::Clock::time_point now) {
  Vital vital;
  vital.term = leadership_.term();
  vital.heard_mode = ears_.newest_mode_of_others();
  switch (leadership_.role()) {
    case Leadership::Role::kListening:
      vital.state = msg::NodeState::NODE_STARTING;
      vital.detail = "listens for others before it leads";
      break;
    case Leadership::Role::kStandingBy:
      vital.state = msg::NodeState::NODE_STANDBY;
      vital.detail = "another supervisor leads" + (memory_.forgetful() ? "; " + memory_.failure() : std::string());
      break;
    case Leadership::Role::kLeading:
      if (!memory_.forgetful()) break;
      vital.state = msg::NodeState::NODE_DEGRADED;
      vital.detail = memory_.failure();
      break;
  }
  pulse_.beat(now, vital, loop_);
}

}  // namespace hecaton::services
