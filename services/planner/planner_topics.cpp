#include "services/planner/planner_topics.hpp"

#include <utility>

#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {

PlannerSubscriptions::PlannerSubscriptions(bus::Participant& participant, bus::Mailbox& mailbox, std::string arm)
    : arm_(std::move(arm)),
      mailbox_(mailbox),
      arm_states_(participant, &mailbox),
      obstacle_shapes_(participant, &mailbox),
      obstacle_states_(participant, &mailbox),
      scans_(participant, &mailbox),
      goals_(participant, &mailbox),
      statuses_(participant, &mailbox),
      proposals_(participant, &mailbox),
      progress_(participant, &mailbox) {}

void PlannerSubscriptions::complain(const std::optional<std::string>& unusable) {
  if (!unusable || unusable == complaint_) return;
  complaint_ = unusable;
  log_warning("message ignored", {{"reason", *unusable}});
}

std::vector<msg::GoalStatus> PlannerSubscriptions::update(LivePlanner& planner) {
  (void)mailbox_.take_events();
  ArmView& arms = planner.arms();
  std::vector<msg::GoalStatus> usable;
  for (const auto& sample : arm_states_.take()) {
    if (!sample.disposed) complain(arms.apply(sample.value, sample.writer, sample.received));
  }
  for (auto& sample : statuses_.take()) {
    if (sample.disposed) continue;
    const auto unusable = arms.apply(sample.value);
    complain(unusable);
    if (!unusable) usable.push_back(std::move(sample.value));
  }
  for (const auto& sample : proposals_.take()) {
    if (!sample.disposed && sample.value.arm() != arm_) complain(arms.apply(sample.value));
  }
  for (const auto& sample : progress_.take()) {
    if (!sample.disposed && sample.value.arm() != arm_) complain(arms.apply(sample.value));
  }
  update_obstacles(planner.obstacles());
  for (const auto& sample : scans_.take()) {
    if (!sample.disposed) complain(planner.apply(sample.value, sample.writer, sample.received));
  }
  return usable;
}

void PlannerSubscriptions::update_obstacles(ObstacleView& obstacles) {
  for (const auto& sample : obstacle_shapes_.take()) {
    if (sample.disposed) {
      obstacles.withdraw(sample.key);
    } else {
      complain(obstacles.apply(sample.value));
    }
  }
  for (const auto& sample : obstacle_states_.take()) {
    complain(obstacles.apply(sample.value, sample.writer, sample.received));
  }
  obstacles.join();
}

std::vector<msg::Goal> PlannerSubscriptions::take_goals() {
  std::vector<msg::Goal> goals;
  for (auto& sample : goals_.take()) {
    if (!sample.disposed) goals.push_back(std::move(sample.value));
  }
  return goals;
}

CoordinationPublisher::CoordinationPublisher(bus::Participant& participant, std::vector<std::string> arms, int self,
                                             std::string node)
    : arms_(std::move(arms)),
      self_(self),
      node_(std::move(node)),
      proposal_writer_(participant),
      progress_writer_(participant) {}

void CoordinationPublisher::publish(const std::shared_ptr<const planner::CoupledPlan>& proposal,
                                    const planner::CoupledPlanProgress& progress) {
  const bool begins = !std::exchange(begun_, true);
  if (begins || proposal != proposal_) {
    proposal_ = proposal;
    write_proposal();
  }
  if (begins || progress != progress_) {
    const bool took_part = progress_.proposer >= 0;
    const bool takes_part = progress.proposer >= 0;
    if (takes_part != took_part) {
      log_info(takes_part ? "joins a coupled plan" : "leaves a coupled plan", {{"arm", arms_[self_]}});
    }
    progress_ = progress;
    write_progress();
  }
}

// The bus logs a refusal of either; other arms do not join then, or wait for this one, and leave.
void CoordinationPublisher::write_proposal() {
  msg::CoupledPlan message;
  message.arm(arms_[self_]);
  message.node(node_);
  message.stamp_ns(stamp_now());
  if (proposal_) {
    message.number(proposal_->number);
    for (const int arm : proposal_->arms) message.arms().push_back(arms_[arm]);
    message.points(static_cast<std::uint32_t>(proposal_->points.size()));
    for (const auto& point : proposal_->points) {
      for (const planner::JointVector& q : point) message.q().insert(message.q().end(), q.begin(), q.end());
    }
  }
  (void)proposal_writer_.write(message);
}

void CoordinationPublisher::write_progress() {
  msg::CoupledPlanProgress message;
  message.arm(arms_[self_]);
  message.node(node_);
  message.stamp_ns(stamp_now());
  if (progress_.proposer >= 0) message.proposer(arms_[progress_.proposer]);
  message.number(progress_.number);
  message.reached(progress_.reached);
  (void)progress_writer_.write(message);
}

}  // namespace hecaton::services
