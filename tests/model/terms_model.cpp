#include "tests/model/terms_model.hpp"

#include <algorithm>
#include <cassert>
#include <chrono>

namespace hecaton::services::model {
namespace {

using namespace std::chrono_literals;

const std::string kArm = "arm";
const std::array<std::string, 3> kPlanners{"p", "q", ""};
constexpr std::size_t kNobody = 2;
// Time stands still while anything may happen; whoever loses patience does so now.
constexpr Leadership::Time kNow{0};
constexpr Leadership::Time kPatienceIsOver = 1h;
constexpr Leadership::Time kCalmRound = 100ms;
constexpr int kCalmRounds = 15;

std::uint8_t small(std::uint64_t term) {
  return static_cast<std::uint8_t>(term);
}

std::uint8_t index_of(const std::string& planner) {
  const auto found = std::find(kPlanners.begin(), kPlanners.end(), planner);
  assert(found != kPlanners.end());
  return static_cast<std::uint8_t>(found - kPlanners.begin());
}

Mandate mandate_of(const Letter& letter) {
  return {kPlanners[letter.planner], letter.granted};
}

std::string text(const Letter& letter) {
  const std::string mandate = kPlanners[letter.planner] + ":" + std::to_string(letter.granted);
  switch (letter.kind) {
    case Letter::Kind::kMode:
      return "mode " + std::to_string(letter.term) + " of supervisor " + std::to_string(letter.sender) + " granting " +
             mandate;
    case Letter::Kind::kCommand:
      return "command " + mandate;
    case Letter::Kind::kState:
      break;
  }
  return "state with " + mandate;
}

msg::CellMode message_of(const Letter& mode) {
  msg::CellMode message;
  message.term(mode.term);
  if (mode.granted == 0) return message;
  msg::Grant& grant = message.grants().emplace_back();
  grant.arm(kArm);
  grant.planner(kPlanners[mode.planner]);
  grant.term(mode.granted);
  return message;
}

}  // namespace

Cell::Cell(const Rules& rules, const Bounds& bounds)
    : rules_(rules),
      bounds_(bounds),
      supervisors_{born_supervisor(0, 0), born_supervisor(1, 0)},
      planners_{born_planner(0), born_planner(1)} {}

Cell::SupervisorProcess Cell::born_supervisor(int i, std::uint64_t memory) const {
  Leadership::Seat seat;
  if (rules_.unique_terms) seat = {static_cast<std::uint64_t>(i), 2};
  const Leadership::Limits limits{.pause = kPatienceIsOver};
  return {Leadership(limits, memory, kNow, seat), Succession({{kArm, {kPlanners[0], kPlanners[1]}}}), memory};
}

Cell::PlannerProcess Cell::born_planner(int j) {
  return {CellModeView(), Duty(kPlanners[static_cast<std::size_t>(j)], j == 0)};
}

bool Cell::leads(int i) const {
  return supervisors_[i].leadership.role() == Leadership::Role::kLeading;
}

Letter Cell::mode_of(int i) const {
  const Mandate mandate = supervisors_[i].succession.mandate_of(kArm);
  return {Letter::Kind::kMode, static_cast<std::uint8_t>(i), small(supervisors_[i].leadership.term()),
          small(mandate.term), index_of(mandate.planner)};
}

Letter Cell::command_of(int j) const {
  return {Letter::Kind::kCommand, 0, 0, small(planners_[j].duty.term()), static_cast<std::uint8_t>(j)};
}

Letter Cell::driver_state() const {
  const Mandate& mandate = driver_.gate.mandate();
  return {Letter::Kind::kState, 0, 0, small(mandate.term), index_of(mandate.planner)};
}

/// As the nodes' heartbeats tell them.
std::array<std::uint64_t, 3> Cell::followed_terms() const {
  return {planners_[0].view.term(), planners_[1].view.term(), driver_.view.term()};
}

// Who has something to say says it at once: it may arrive as late as it likes.
void Cell::send() {
  const auto add = [this](const Letter& letter) {
    const auto place = std::lower_bound(letters_.begin(), letters_.end(), letter);
    if (place == letters_.end() || *place != letter) letters_.insert(place, letter);
  };
  for (const int i : {0, 1}) {
    if (leads(i)) add(mode_of(i));
    if (planners_[i].duty.in_charge()) add(command_of(i));
  }
  if (driver_.gate.mandate().term > 0) add(driver_state());
}

void Cell::supervisor_hears(int i, const Letter& letter, Leadership::Time at) {
  SupervisorProcess& supervisor = supervisors_[i];
  if (letter.kind == Letter::Kind::kMode && letter.sender != i) {
    supervisor.leadership.heard_leader(letter.term, at);
    supervisor.succession.hear(kArm, mandate_of(letter));
  }
  if (letter.kind == Letter::Kind::kState && rules_.driver_proves) {
    supervisor.succession.hear_driver(kArm, mandate_of(letter));
  }
}

void Cell::planner_hears(int j, const Letter& letter) {
  PlannerProcess& planner = planners_[j];
  if (letter.kind == Letter::Kind::kMode) {
    static_cast<void>(planner.view.apply(message_of(letter)));
    planner.duty.hear(planner.view.mandate(kArm));
  }
  if (letter.kind == Letter::Kind::kState && rules_.driver_proves) planner.duty.hear_driver(mandate_of(letter));
}

void Cell::driver_hears(const Letter& letter) {
  if (letter.kind == Letter::Kind::kMode) {
    static_cast<void>(driver_.view.apply(message_of(letter)));
    Mandate mandate = driver_.view.mandate(kArm);
    proved_ = std::max(proved_, small(mandate.term));
    if (!rules_.binding) mandate.planner.clear();
    driver_.gate.saw(mandate);
  }
  if (letter.kind != Letter::Kind::kCommand) return;
  msg::ArmCommand command;
  command.node(kPlanners[rules_.binding ? letter.planner : kNobody]);
  command.term(letter.granted);
  command.sequence_number(driver_.gate.sequence() + 1);  // the worst case: never refused for its number
  command.period(0.01);
  command.q({0.0});
  command.qd({0.0});
  if (driver_.gate.judge(command) == Verdict::kAccepted || !rules_.gate) driver_follows(letter);
}

void Cell::driver_follows(const Letter& command) {
  if (command.granted < followed_.granted) violation_ = "the driver goes back to a " + text(command);
  if (command.granted < proved_) {
    violation_ = "the driver follows a " + text(command) + " although it knows of term " + std::to_string(proved_);
  }
  if (command.granted == followed_.granted && command.planner != followed_.planner) {
    violation_ = "the driver follows two planners in term " + std::to_string(command.granted);
  }
  followed_ = command;
  proved_ = std::max(proved_, command.granted);
}

void Cell::decide(int i, Leadership::Time now) {
  SupervisorProcess& supervisor = supervisors_[i];
  if (!supervisor.leadership.decide(now, now)) return;
  supervisor.memory = supervisor.leadership.term();
  grant(i, -1);  // before it says anything
}

/// `out`: the planner that it takes for dead or hanging; the other is ready.
void Cell::grant(int i, int out) {
  const auto fitness = [&](const std::string&, const std::string& planner) {
    const bool is_out = out >= 0 && planner == kPlanners[static_cast<std::size_t>(out)];
    return PlannerFitness{is_out, !is_out};
  };
  static_cast<void>(supervisors_[i].succession.decide(fitness, supervisors_[i].leadership));
}

void Cell::step(const Visit& visit, const std::string& what, const std::function<void(Cell&)>& action) const {
  Cell next(*this);
  action(next);
  next.send();
  visit(std::move(next), what);
}

void Cell::for_each_successor(const Visit& visit) const {
  for (const Letter& letter : letters_) {
    for (const int i : {0, 1}) {
      const std::string n = std::to_string(i);
      step(visit, "supervisor " + n + " hears " + text(letter), [&](Cell& c) { c.supervisor_hears(i, letter, kNow); });
      step(visit, "planner " + kPlanners[i] + " hears " + text(letter), [&](Cell& c) { c.planner_hears(i, letter); });
    }
    step(visit, "driver hears " + text(letter), [&](Cell& c) { c.driver_hears(letter); });
  }
  for (const int i : {0, 1}) {
    const std::string name = "supervisor " + std::to_string(i);
    for (const std::uint64_t term : followed_terms()) {
      step(visit, name + " hears a beat of term " + std::to_string(term),
           [&](Cell& c) { c.supervisors_[i].leadership.heard_term(term, kNow); });
    }
    for (const PlannerProcess& planner : planners_) {
      if (!rules_.planners_prove) break;
      const Mandate mandate = planner.duty.mandate();
      step(visit, name + " hears a planner of mandate " + mandate.planner + ":" + std::to_string(mandate.term),
           [&](Cell& c) { c.supervisors_[i].succession.hear(kArm, mandate); });
    }
    const std::uint64_t known =
        std::max(supervisors_[i].leadership.highest(), supervisors_[i].succession.mandate_of(kArm).term);
    if (!leads(i) && known + 4 <= bounds_.highest_term) {
      step(visit, name + " loses patience", [&](Cell& c) { c.decide(i, kPatienceIsOver); });
    }
    if (!leads(i) || known + 2 > bounds_.highest_term) continue;
    for (const int out : {-1, 0, 1}) {
      step(visit, name + " decides on the planners, out: " + std::to_string(out), [&](Cell& c) { c.grant(i, out); });
    }
  }
  if (deaths_ < bounds_.deaths) deaths(visit);
}

void Cell::deaths(const Visit& visit) const {
  for (const int i : {0, 1}) {
    for (const bool forgets : {false, true}) {
      step(visit, "supervisor " + std::to_string(i) + (forgets ? " dies and forgets" : " dies"), [&](Cell& c) {
        c.supervisors_[i] = c.born_supervisor(i, forgets ? 0 : c.supervisors_[i].memory);
        ++c.deaths_;
      });
    }
    step(visit, "planner " + kPlanners[i] + " dies", [&](Cell& c) {
      c.planners_[i] = born_planner(i);
      ++c.deaths_;
    });
  }
  // Another life of the driver: what its predecessor followed was another arm's movement, one could say.
  step(visit, "driver dies", [](Cell& c) {
    c.driver_ = {};
    c.followed_ = {};
    c.proved_ = 0;
    ++c.deaths_;
  });
}

std::string Cell::processes() const {
  std::string key;
  const auto add = [&key](std::uint64_t value) { key.push_back(static_cast<char>(value)); };
  const auto add_mandate = [&](const Mandate& mandate) {
    add(mandate.term);
    add(index_of(mandate.planner));
  };
  for (const SupervisorProcess& supervisor : supervisors_) {
    const Leadership& leadership = supervisor.leadership;
    const bool leads = leadership.role() == Leadership::Role::kLeading;  // else its last term means nothing any more
    add(static_cast<std::uint64_t>(leadership.role()) * 2 + (!leads && leadership.hears_leader() ? 1 : 0));
    add(leads ? leadership.term() : 0);
    add(leadership.highest());
    add(supervisor.memory);
    add_mandate(supervisor.succession.mandate_of(kArm));
  }
  // What a view tells of mandates was taken over at once; later only its term counts.
  for (const PlannerProcess& planner : planners_) {
    add(planner.view.term());
    add_mandate(planner.duty.mandate());
  }
  add(driver_.view.term());
  add_mandate(driver_.gate.mandate());
  add(followed_.granted);
  add(followed_.planner);
  add(proved_);
  add(deaths_);
  return key;
}

// Everybody hears what everybody else said in the round before.
void Cell::calm_round(const Dead& dead, Leadership::Time now) {
  std::vector<Letter> modes;
  for (const int i : {0, 1}) {
    if (i != dead.supervisor && leads(i)) modes.push_back(mode_of(i));
  }
  for (const Letter& mode : modes) {
    driver_hears(mode);
    for (const int j : {0, 1}) planner_hears(j, mode);
  }
  for (const int i : {0, 1}) {
    if (i == dead.supervisor) continue;
    for (const Letter& mode : modes) supervisor_hears(i, mode, now);
    for (const std::uint64_t term : followed_terms()) supervisors_[i].leadership.heard_term(term, now);
    for (const int j : {0, 1}) {
      if (rules_.planners_prove && j != dead.planner)
        supervisors_[i].succession.hear(kArm, planners_[j].duty.mandate());
    }
    supervisor_hears(i, driver_state(), now);
    decide(i, now);
    if (leads(i)) grant(i, dead.planner);
  }
  for (const int j : {0, 1}) {
    planner_hears(j, driver_state());
    if (j != dead.planner && planners_[j].duty.in_charge()) driver_hears(command_of(j));
  }
}

std::string Cell::wrong_after_calm(const Dead& dead) const {
  Cell cell(*this);
  cell.followed_ = {};
  Leadership::Time now = kPatienceIsOver;
  for (int round = 0; round < kCalmRounds; ++round) {
    if (round == kCalmRounds - 1) cell.followed_ = {};  // what is followed now is followed for good
    cell.calm_round(dead, now);
    now += kCalmRound;
  }
  const int living = dead.supervisor < 0 ? -1 : 1 - dead.supervisor;
  const bool one_leads = living < 0 ? cell.leads(0) != cell.leads(1) : cell.leads(living);
  if (!one_leads) return "not one supervisor leads";
  const int leader = living < 0 ? (cell.leads(0) ? 0 : 1) : living;
  const Letter told = cell.mode_of(leader);
  if (told.planner == Letter::kNobody || told.planner == dead.planner) return "no living planner is in charge";
  if (cell.followed_.granted == 0) return "the driver follows nobody";
  if (cell.followed_.planner != told.planner) return "the driver follows another planner than the supervisor tells";
  if (!cell.violation_.empty()) return cell.violation_;
  return {};
}

}  // namespace hecaton::services::model
