#include "services/planner/company.hpp"

#include <utility>

#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

/// What numbers of plans begin after: greater than any that this planner gave before it was restarted.
std::uint32_t milliseconds_now() {
  return static_cast<std::uint32_t>(stamp_now() / 1'000'000);
}

std::vector<std::string> names_of(const std::vector<planner::Arm>& arms) {
  std::vector<std::string> names;
  for (const planner::Arm& arm : arms) names.push_back(arm.name);
  return names;
}

}  // namespace

Company::Company(bus::Participant& participant, bus::Mailbox* mailbox, std::vector<planner::Arm> arms,
                 std::vector<planner::LocalParameters> parameters, int self, std::string node, std::uint64_t seed)
    : names_(names_of(arms)),
      self_(self),
      node_(std::move(node)),
      proposals_(participant, mailbox),
      progress_of_others_(participant, mailbox),
      proposal_(participant),
      progress_(participant),
      policy_(parameters[self], seed, milliseconds_now()),
      routes_(std::move(arms), std::move(parameters), self) {}

void Company::listen(ArmView& view, const std::function<void(const std::string&)>& complain) {
  for (const auto& sample : proposals_.take()) {
    if (!sample.disposed && sample.value.arm() != names_[self_]) complain(view.apply(sample.value));
  }
  for (const auto& sample : progress_of_others_.take()) {
    if (!sample.disposed && sample.value.arm() != names_[self_]) complain(view.apply(sample.value));
  }
}

void Company::plan(planner::ArmController& controller, const planner::TickResult& result,
                   std::span<const planner::ArmObservation> arms, std::span<const world::ObstacleState> states,
                   const RouteWorker::Obstacles& obstacles) {
  if (const auto answer = routes_.answer()) policy_.answered(answer->route);
  const bool took_part = takes_part();
  if (auto question = policy_.next(controller, result, arms, states)) routes_.ask(std::move(*question), obstacles);
  if (takes_part() != took_part) {
    log_info(took_part ? "leaves a plan for several arms" : "joins a plan for several arms", {{"arm", names_[self_]}});
  }
  publish();
}

void Company::resign(planner::ArmController& controller) {
  policy_.resign(controller);
  has_said_ = false;
}

// Who begins says that it takes part in nothing: the planner before it, of this name or another, may have died in the
// midst of a plan, and the others wait for the arm.
void Company::publish() {
  const bool first = !std::exchange(has_said_, true);
  if (first || policy_.proposal() != published_plan_) publish_proposal();
  const planner::CompositeProgress& progress = policy_.progress();
  if (!first && progress == published_progress_) return;
  published_progress_ = progress;
  msg::CompositeProgress message;
  message.arm(names_[self_]);
  message.node(node_);
  message.stamp_ns(stamp_now());
  if (progress.proposer >= 0) message.proposer(names_[progress.proposer]);
  message.number(progress.number);
  message.reached(progress.reached);
  (void)progress_.write(message);  // the bus logs a refusal; the others wait for us, and then leave
}

void Company::publish_proposal() {
  published_plan_ = policy_.proposal();
  msg::CompositePlan message;
  message.arm(names_[self_]);
  message.node(node_);
  message.stamp_ns(stamp_now());
  if (published_plan_) {
    message.number(published_plan_->number);
    for (const int arm : published_plan_->arms) message.arms().push_back(names_[arm]);
    message.points(static_cast<std::uint32_t>(published_plan_->points.size()));
    for (const auto& point : published_plan_->points) {
      for (const planner::JointVector& q : point) message.q().insert(message.q().end(), q.begin(), q.end());
    }
  }
  (void)proposal_.write(message);  // the bus logs a refusal; nobody joins then
}

}  // namespace hecaton::services
