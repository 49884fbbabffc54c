#include "tests/model/terms_processes.hpp"

#include <algorithm>
#include <chrono>

namespace hecaton::services::model {
namespace {

using namespace std::chrono_literals;

const std::string kArm = "arm";

msg::CellMode cell_mode_of(const Message& mode) {
  msg::CellMode message;
  message.term(mode.term);
  if (mode.granted == 0) return message;
  msg::ArmLease& grant = message.leases().emplace_back();
  grant.arm(kArm);
  grant.planner(planner_name(mode.planner));
  grant.term(mode.granted);
  return message;
}

Message heartbeat_of(const CellModeView& view) {
  Message heartbeat{.kind = Message::Kind::kHeartbeat};
  heartbeat.term = static_cast<std::uint8_t>(view.term());
  return heartbeat;
}

Leadership leadership_of(const Rules& rules, int index, std::uint64_t remembered) {
  Leadership::TermShare share;
  if (rules.unique_terms) share = {static_cast<std::uint64_t>(index), 2};
  return {{.pause = 1h}, remembered, Leadership::Time(0), share};
}

void add(std::string& key, std::uint64_t value) {
  key.push_back(static_cast<char>(value));
}

void add(std::string& key, const ArmLease& lease) {
  add(key, lease.term);
  add(key, planner_index(lease.planner));
}

}  // namespace

SupervisorProcess::SupervisorProcess(const Rules& rules, int index)
    : rules_(rules),
      index_(index),
      leadership_(leadership_of(rules, index, 0)),
      failover_({{kArm, {planner_name(0), planner_name(1)}}}) {}

SupervisorProcess SupervisorProcess::successor(const Rules& rules, int index, std::uint64_t remembered) {
  SupervisorProcess process(rules, index);
  process.is_successor_ = true;
  process.leadership_ = leadership_of(rules, index, remembered);
  return process;
}

// A mutant limits every received term to its own.
std::uint64_t SupervisorProcess::counted(std::uint64_t term) const {
  return rules_.counts_observed ? term : std::min(term, cell_term());
}

void SupervisorProcess::receive(const Message& message, Time now) {
  switch (message.kind) {
    case Message::Kind::kMode:
      return receive_mode(message, now);
    case Message::Kind::kState:
      if (rules_.driver_proves) failover_.update_from_driver(kArm, message.lease());
      return;
    case Message::Kind::kHeartbeat:
      return leadership_.observe_term(counted(message.term), now);
    case Message::Kind::kKnownLease:
      if (rules_.planners_prove) failover_.update(kArm, message.lease());
      return;
    case Message::Kind::kCommand:
      return;
  }
}

// A listening supervisor that hears a leader stands by at once: until then it could do nothing else.
void SupervisorProcess::receive_mode(const Message& mode, Time now) {
  if (mode.sender == index_ && !is_successor_) return;
  leadership_.observe_leader(counted(mode.term), now);
  static_cast<void>(leadership_.decide(now, now));
  failover_.update(kArm, mode.lease());
}

void SupervisorProcess::miss_leader(Time now) {
  if (leadership_.decide(now, now)) grant(-1);  // before it sends anything
}

void SupervisorProcess::detect_absence(Time now) {
  if (leads()) leadership_.restart_listening(now);
}

void SupervisorProcess::grant(int failed) {
  if (!leads()) return;
  const auto health = [&](const std::string&, const std::string& planner) {
    const bool has_failed = failed >= 0 && planner == planner_name(static_cast<std::size_t>(failed));
    return PlannerHealth{has_failed, !has_failed};
  };
  static_cast<void>(failover_.decide(health, leadership_));
}

std::uint64_t SupervisorProcess::next_term() const {
  Leadership would(leadership_);
  return would.take_term();
}

ArmLease SupervisorProcess::lease() const {
  return failover_.lease(kArm);
}

std::vector<Message> SupervisorProcess::sends() const {
  if (!leads()) return {};
  Message mode = message_about(Message::Kind::kMode, lease());
  mode.sender = static_cast<std::uint8_t>(index_);
  mode.term = static_cast<std::uint8_t>(cell_term());
  return {mode};
}

// Of all observed terms only the next one that it would take matters, and of its own terms the one under which it
// leads.
std::string SupervisorProcess::key() const {
  std::string key;
  add(key, static_cast<std::uint64_t>(index_));
  add(key, is_successor_ ? 1 : 0);
  add(key, static_cast<std::uint64_t>(role()));
  add(key, leads() ? cell_term() : 0);
  add(key, next_term());
  add(key, lease());
  return key;
}

PlannerProcess::PlannerProcess(const Rules& rules, int index)
    : rules_(rules), index_(index), role_(planner_name(static_cast<std::size_t>(index)), index == 0) {}

void PlannerProcess::receive(const Message& message) {
  if (message.kind == Message::Kind::kMode) {
    static_cast<void>(view_.apply(cell_mode_of(message)));
    role_.update(view_.lease(kArm));
  }
  if (message.kind == Message::Kind::kState && rules_.driver_proves) role_.update_from_driver(message.lease());
}

std::vector<Message> PlannerProcess::sends() const {
  std::vector<Message> messages;
  if (view_.term() > 0) messages.push_back(heartbeat_of(view_));
  if (role_.term() > 0) messages.push_back(message_about(Message::Kind::kKnownLease, role_.lease()));
  if (role_.in_charge()) {
    messages.push_back(
        message_about(Message::Kind::kCommand, {planner_name(static_cast<std::size_t>(index_)), role_.term()}));
  }
  return messages;
}

// The leases of the view were adopted at once; afterwards only its term matters.
std::string PlannerProcess::key() const {
  std::string key;
  add(key, static_cast<std::uint64_t>(index_));
  add(key, view_.term());
  add(key, role_.lease());
  return key;
}

void DriverProcess::receive(const Message& message) {
  if (message.kind == Message::Kind::kMode) receive_mode(message);
  if (message.kind == Message::Kind::kCommand) receive_command(message);
}

void DriverProcess::receive_mode(const Message& mode) {
  static_cast<void>(view_.apply(cell_mode_of(mode)));
  ArmLease lease = view_.lease(kArm);
  prove(lease.term);
  if (!rules_.binding) lease.planner.clear();
  gate_.observe_lease(lease);
}

void DriverProcess::receive_command(const Message& message) {
  msg::ArmCommand command;
  command.node(planner_name(rules_.binding ? message.planner : kNoPlanner));
  command.term(message.granted);
  command.sequence_number(gate_.sequence() + 1);  // the worst case: the number is never a reason to refuse
  command.period(0.01);
  command.q({0.0});
  command.qd({0.0});
  if (gate_.judge(command).verdict == Verdict::kAccepted || !rules_.gate) follow(message);
}

void DriverProcess::follow(const Message& command) {
  if (command.granted < proved_) {
    violation_ = "the driver follows a " + text(command) + " although it knows term " + std::to_string(proved_);
  }
  if (command.granted == followed_.term && command.lease() != followed_) {
    violation_ = "the driver follows two planners in term " + std::to_string(command.granted);
  }
  prove(command.granted);
  followed_ = command.lease();
}

// From now on the arm must not follow an older term.
void DriverProcess::prove(std::uint64_t term) {
  proved_ = std::max(proved_, term);
  if (followed_.term < proved_) followed_ = {};
}

// Like ArmDriver: it begins with its checkpoint only, which is the lease in force when it last published its state.
void DriverProcess::restart() {
  const ArmLease remembered = gate_.lease();
  view_ = {};
  gate_ = CommandGate(1);
  if (rules_.driver_has_checkpoint) gate_.observe_lease(remembered);
}

std::vector<Message> DriverProcess::sends() const {
  std::vector<Message> messages;
  if (view_.term() > 0) messages.push_back(heartbeat_of(view_));
  if (lease().term > 0) messages.push_back(message_about(Message::Kind::kState, lease()));
  return messages;
}

std::string DriverProcess::key() const {
  std::string key;
  add(key, view_.term());
  add(key, lease());
  add(key, followed_);
  add(key, proved_);
  return key + violation_;
}

}  // namespace hecaton::services::model
