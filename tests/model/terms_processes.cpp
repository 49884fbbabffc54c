#include "tests/model/terms_processes.hpp"

#include <algorithm>
#include <chrono>

namespace hecaton::services::model {
namespace {

using namespace std::chrono_literals;

const std::string kArm = "arm";

msg::CellMode message_of(const Letter& mode) {
  msg::CellMode message;
  message.term(mode.term);
  if (mode.granted == 0) return message;
  msg::ArmLease& grant = message.leases().emplace_back();
  grant.arm(kArm);
  grant.planner(planner_name(mode.planner));
  grant.term(mode.granted);
  return message;
}

Letter beat_of(const CellModeView& view) {
  Letter beat{.kind = Letter::Kind::kBeat};
  beat.term = static_cast<std::uint8_t>(view.term());
  return beat;
}

Leadership leadership_of(const Rules& rules, int index, std::uint64_t remembered) {
  Leadership::Seat seat;
  if (rules.unique_terms) seat = {static_cast<std::uint64_t>(index), 2};
  return {{.pause = 1h}, remembered, Leadership::Time(0), seat};
}

void add(std::string& key, std::uint64_t value) {
  key.push_back(static_cast<char>(value));
}

void add(std::string& key, const ArmLease& mandate) {
  add(key, mandate.term);
  add(key, planner_index(mandate.planner));
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

// A mutant takes whatever it hears for no more than its own.
std::uint64_t SupervisorProcess::counted(std::uint64_t term) const {
  return rules_.counts_heard ? term : std::min(term, cell_term());
}

void SupervisorProcess::hear(const Letter& letter, Time now) {
  switch (letter.kind) {
    case Letter::Kind::kMode:
      return hear_mode(letter, now);
    case Letter::Kind::kState:
      if (rules_.driver_proves) failover_.hear_driver(kArm, letter.mandate());
      return;
    case Letter::Kind::kBeat:
      return leadership_.heard_term(counted(letter.term), now);
    case Letter::Kind::kHeld:
      if (rules_.planners_prove) failover_.hear(kArm, letter.mandate());
      return;
    case Letter::Kind::kCommand:
      return;
  }
}

// Who hears a leader while it listens stands by at once: until then it would do nothing else.
void SupervisorProcess::hear_mode(const Letter& mode, Time now) {
  if (mode.sender == index_ && !is_successor_) return;
  leadership_.heard_leader(counted(mode.term), now);
  static_cast<void>(leadership_.decide(now, now));
  failover_.hear(kArm, mode.mandate());
}

void SupervisorProcess::lose_patience(Time now) {
  if (leadership_.decide(now, now)) grant(-1);  // before it says anything
}

void SupervisorProcess::come_back(Time now) {
  if (leads()) leadership_.absent(now);
}

void SupervisorProcess::grant(int out) {
  if (!leads()) return;
  const auto fitness = [&](const std::string&, const std::string& planner) {
    const bool is_out = out >= 0 && planner == planner_name(static_cast<std::size_t>(out));
    return PlannerHealth{is_out, !is_out};
  };
  static_cast<void>(failover_.decide(fitness, leadership_));
}

std::uint64_t SupervisorProcess::next_term() const {
  Leadership would(leadership_);
  return would.take_term();
}

ArmLease SupervisorProcess::mandate() const {
  return failover_.lease(kArm);
}

std::vector<Letter> SupervisorProcess::tells() const {
  if (!leads()) return {};
  Letter mode = letter_about(Letter::Kind::kMode, mandate());
  mode.sender = static_cast<std::uint8_t>(index_);
  mode.term = static_cast<std::uint8_t>(cell_term());
  return {mode};
}

// Of the terms that it has heard of only the next one that it would take matters, and of its own the one under which it
// leads.
std::string SupervisorProcess::key() const {
  std::string key;
  add(key, static_cast<std::uint64_t>(index_));
  add(key, is_successor_ ? 1 : 0);
  add(key, static_cast<std::uint64_t>(role()));
  add(key, leads() ? cell_term() : 0);
  add(key, next_term());
  add(key, mandate());
  return key;
}

PlannerProcess::PlannerProcess(const Rules& rules, int index)
    : rules_(rules), index_(index), duty_(planner_name(static_cast<std::size_t>(index)), index == 0) {}

void PlannerProcess::hear(const Letter& letter) {
  if (letter.kind == Letter::Kind::kMode) {
    static_cast<void>(view_.apply(message_of(letter)));
    duty_.hear(view_.lease(kArm));
  }
  if (letter.kind == Letter::Kind::kState && rules_.driver_proves) duty_.hear_driver(letter.mandate());
}

std::vector<Letter> PlannerProcess::tells() const {
  std::vector<Letter> letters;
  if (view_.term() > 0) letters.push_back(beat_of(view_));
  if (duty_.term() > 0) letters.push_back(letter_about(Letter::Kind::kHeld, duty_.mandate()));
  if (duty_.in_charge()) {
    letters.push_back(
        letter_about(Letter::Kind::kCommand, {planner_name(static_cast<std::size_t>(index_)), duty_.term()}));
  }
  return letters;
}

// What the view tells of mandates was taken over at once; later only its term counts.
std::string PlannerProcess::key() const {
  std::string key;
  add(key, static_cast<std::uint64_t>(index_));
  add(key, view_.term());
  add(key, duty_.mandate());
  return key;
}

void DriverProcess::hear(const Letter& letter) {
  if (letter.kind == Letter::Kind::kMode) hear_mode(letter);
  if (letter.kind == Letter::Kind::kCommand) hear_command(letter);
}

void DriverProcess::hear_mode(const Letter& mode) {
  static_cast<void>(view_.apply(message_of(mode)));
  ArmLease mandate = view_.lease(kArm);
  prove(mandate.term);
  if (!rules_.binding) mandate.planner.clear();
  gate_.saw(mandate);
}

void DriverProcess::hear_command(const Letter& letter) {
  msg::ArmCommand command;
  command.node(planner_name(rules_.binding ? letter.planner : kNobody));
  command.term(letter.granted);
  command.sequence_number(gate_.sequence() + 1);  // the worst case: never refused for its number
  command.period(0.01);
  command.q({0.0});
  command.qd({0.0});
  if (gate_.judge(command).verdict == Verdict::kAccepted || !rules_.gate) follow(letter);
}

void DriverProcess::follow(const Letter& command) {
  if (command.granted < proved_) {
    violation_ = "the driver follows a " + text(command) + " although it knows of term " + std::to_string(proved_);
  }
  if (command.granted == followed_.term && command.mandate() != followed_) {
    violation_ = "the driver follows two planners in term " + std::to_string(command.granted);
  }
  prove(command.granted);
  followed_ = command.mandate();
}

// To follow anything older is wrong from now on, whatever was followed before.
void DriverProcess::prove(std::uint64_t term) {
  proved_ = std::max(proved_, term);
  if (followed_.term < proved_) followed_ = {};
}

// As ArmDriver begins: with nothing but what its memory has, which is what it went by when it last told its state.
void DriverProcess::restart() {
  const ArmLease remembered = gate_.lease();
  view_ = {};
  gate_ = CommandGate(1);
  if (rules_.driver_remembers) gate_.saw(remembered);
}

std::vector<Letter> DriverProcess::tells() const {
  std::vector<Letter> letters;
  if (view_.term() > 0) letters.push_back(beat_of(view_));
  if (mandate().term > 0) letters.push_back(letter_about(Letter::Kind::kState, mandate()));
  return letters;
}

std::string DriverProcess::key() const {
  std::string key;
  add(key, view_.term());
  add(key, mandate());
  add(key, followed_);
  add(key, proved_);
  return key + violation_;
}

}  // namespace hecaton::services::model
