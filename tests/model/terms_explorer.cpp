#include "tests/model/terms_explorer.hpp"

#include <algorithm>

namespace hecaton::services::model {
namespace {

using Kind = Step::Kind;
using Sentences = std::vector<std::string>;

bool was_sent(const Cell& cell, const Actors& actors, const auto& condition) {
  bool sent = false;
  cell.messages.for_each([&](std::size_t message) { sent = sent || condition(actors.message(message)); });
  return sent;
}

void of_grants(const std::string& name, const Cell& before, const ArmLease& granted, const Actors& actors,
               Sentences& sentences) {
  const auto another_has_it = [&](const Message& message) {
    return message.kind == Message::Kind::kMode && message.granted == granted.term && message.lease() != granted;
  };
  if (was_sent(before, actors, another_has_it)) sentences.push_back(name + " grants a term that another planner has");
}

Sentences of_failover(const Cell& before, const Step& step, const Cell& after, const Actors& actors) {
  const std::string name = "supervisor " + std::to_string(step.who);
  const SupervisorProcess& was = actors.supervisors()[before.processes.supervisors[step.who]];
  const SupervisorProcess& is = actors.supervisors()[after.processes.supervisors[step.who]];
  const bool stood_by = was.role() == Leadership::Role::kStandingBy;
  Sentences sentences{name + (stood_by ? " stood by and becomes leader" : " listened and becomes leader")};
  if ((before.returned & kSupervisorWithCheckpoint << step.who) != 0) sentences.push_back(name + " returned and leads");
  if ((before.returned & kSupervisorWithoutCheckpoint << step.who) != 0) {
    sentences.push_back(name + " returned without checkpoint and leads");
  }
  if (is.cell_term() <= was.lease().term) sentences.push_back(name + " leads under a term not above a lease");
  of_grants(name, before, is.lease(), actors, sentences);
  return sentences;
}

Sentences of_replacement(const Cell& before, const Step& step, const Cell& after, const Actors& actors) {
  const std::string name = "supervisor " + std::to_string(step.who);
  Sentences sentences{name + " replaces planner " + planner_name(step.what)};
  of_grants(name, before, actors.supervisors()[after.processes.supervisors[step.who]].lease(), actors, sentences);
  return sentences;
}

Sentences of_reception(const Cell& before, const Message& message, const Actors& actors) {
  if (message.kind != Message::Kind::kCommand) return {};
  const std::string planner = planner_name(message.planner);
  const std::string& other = planner_name(1U - message.planner);
  Sentences sentences;
  const auto followed_other = [&](const Message& command) {
    return command.kind == Message::Kind::kCommand && command.lease().planner == other &&
           command.granted < message.granted;
  };
  if (was_sent(before, actors, followed_other))
    sentences.push_back("the driver follows " + planner + " after " + other);
  if ((before.returned & kPlannerReturned << message.planner) != 0) {
    sentences.push_back("planner " + planner + " returned and is followed");
  }
  if ((before.returned & kDriverWithCheckpoint) != 0) sentences.emplace_back("the driver returned and follows");
  if ((before.returned & kDriverWithoutCheckpoint) != 0)
    sentences.emplace_back("the driver returned without checkpoint and follows");
  return sentences;
}

Sentences of_driver_death(const Cell& before, const Actors& actors) {
  const ArmLease& lease = actors.drivers()[before.processes.driver].lease();
  const auto is_stale = [&](const Message& message) {
    return message.kind == Message::Kind::kCommand && message.granted < lease.term;
  };
  if (!was_sent(before, actors, is_stale)) return {};
  return {"the driver returned and may receive a command that it must refuse"};
}

/// Sentences about notable steps. They show that an exploration has passed what it must pass.
Sentences notable(const Cell& before, const Step& step, const Cell& after, const Actors& actors) {
  switch (step.kind) {
    case Kind::kBecomesLeader:
      return of_failover(before, step, after, actors);
    case Kind::kReplaces:
      return of_replacement(before, step, after, actors);
    case Kind::kDriverReceives:
      return of_reception(before, actors.message(step.what), actors);
    case Kind::kDriverDies:
      return of_driver_death(before, actors);
    case Kind::kDetectsAbsence:
      return {"supervisor " + std::to_string(step.who) + " detects that it was stopped"};
    case Kind::kSupervisorReceives:
    case Kind::kPlannerReceives:
    case Kind::kSupervisorDies:
    case Kind::kPlannerDies:
    case Kind::kDriverHostDies:
      break;
  }
  return {};
}

}  // namespace

bool Explorer::dominates(const Found& better, const Found& other) {
  return better.deaths <= other.deaths && better.messages.contains(other.messages);
}

// A dominating state was found since.
bool Explorer::is_dominated(const Cell& cell) const {
  const std::vector<Found>& found = known_.at(cell.processes);
  return std::find(found.begin(), found.end(), Found{cell.messages, cell.deaths}) == found.end();
}

Finding Explorer::explore() {
  add(model_.start(), 0, {});
  while (finding_.wrong.empty() && !frontier_.empty()) {
    const auto first = frontier_.begin();
    const Cell cell = first->second.back().first;
    const std::uint32_t number = first->second.back().second;
    first->second.pop_back();
    if (first->second.empty()) frontier_.erase(first);
    if (is_dominated(cell)) continue;
    model_.for_each_successor(cell, [&](const Cell& next, const Step& step) {
      if (!finding_.wrong.empty()) return;
      for (const std::string& passed : notable(cell, step, next, model_.actors())) ++finding_.coverage[passed];
      add(next, number, step);
    });
  }
  finding_.combinations = known_.size();
  return std::move(finding_);
}

void Explorer::add(const Cell& cell, std::uint32_t before, const Step& step) {
  std::vector<Found>& found = known_[cell.processes];
  finding_.wrong = wrong(cell, found.empty());
  if (!finding_.wrong.empty()) {
    if (trace_.empty()) return;  // the start
    finding_.trace = {text(step, model_.actors())};
    for (std::uint32_t state = before; state > 0; state = trace_[state].before) {
      finding_.trace.push_back(text(trace_[state].step, model_.actors()));
    }
    std::reverse(finding_.trace.begin(), finding_.trace.end());
    return;
  }
  const Found news{cell.messages, cell.deaths};
  if (std::any_of(found.begin(), found.end(), [&](const Found& one) { return dominates(one, news); })) return;
  std::erase_if(found, [&](const Found& one) { return dominates(news, one); });
  found.push_back(news);
  ++finding_.states;
  frontier_[{cell.deaths, -cell.messages.count()}].emplace_back(cell, static_cast<std::uint32_t>(trace_.size()));
  trace_.push_back({before, step});
}

// Recovery depends on the processes alone.
std::string Explorer::wrong(const Cell& cell, bool is_new_combination) {
  const std::string& violation = model_.violation(cell);
  const bool is_checked = checks_ == Checks::kSafetyAndRecovery && is_new_combination;
  return violation.empty() && is_checked ? recovery_.wrong(cell.processes) : violation;
}

}  // namespace hecaton::services::model
