// What a planner does when it, or the other planner of its arm, is put in charge, and when it has been started again:
// so that the arm keeps its goal, whoever commands it (docs/design/0005-return.md).

#include <algorithm>
#include <utility>

#include "services/planner/heed.hpp"
#include "services/planner/planner_service.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

/// Goals of which the other planner may have told something before it is known whether that counts: as many as it
/// keeps on the bus, and some.
constexpr std::size_t kHeardEarly = 64;

}  // namespace

bool PlannerService::hear_mandate() {
  (void)modes_mailbox_.take_events();
  modes_.update();
  duty_.hear(modes_.view().lease(name_));
  return planners_.size() == 1 || duty_.in_charge();
}

void PlannerService::note_duty() {
  if (const auto& own = arms_.arm(self_)) duty_.hear_driver(own->mandate);
  const bool in_charge = hear_mandate();
  // While the drive follows the other's set-points, ours begin where it is.
  if (!in_charge || !in_charge_) controller_.forget_setpoint();
  if (in_charge == in_charge_) return;
  in_charge_ = in_charge;
  log_info(in_charge ? "is in charge" : "stands by", {{"arm", name_}, {"term", duty_.term()}});
}

void PlannerService::hear_the_other(const msg::GoalStatus& status) {
  if (status.arm() != name_ || status.node() == node_) return;
  const Heed what = heed(status, duty_, !remembered_);
  if (what == Heed::kIgnore) return;
  if (what == Heed::kLater) {
    std::erase_if(heard_early_, [&](const msg::GoalStatus& known) { return known.goal() == status.goal(); });
    heard_early_.push_back(status);
    if (heard_early_.size() > kHeardEarly) heard_early_.pop_front();
    return;
  }
  unsaid_.heard(status);
  if (desk_.follow(status, now_)) controller_.set_goal(desk_.q_goal());
  has_news_ = true;
}

// What was heard before it was known who is in charge, or that it is not we any more.
void PlannerService::catch_up() {
  if (remembered_ || duty_.mandate() == caught_up_) return;
  caught_up_ = duty_.mandate();
  has_news_ = true;
  for (const msg::GoalStatus& status : std::exchange(heard_early_, {})) hear_the_other(status);
}

std::optional<LastCommand> PlannerService::last_command() const {
  constexpr double kForEver = 1e9;  // [s]
  const auto& own = arms_.arm(self_);
  if (!own) return std::nullopt;
  const std::chrono::duration<double> age(std::min(own->command_age, kForEver));
  return LastCommand{own->term, own->at.time_since_epoch() - std::chrono::duration_cast<std::chrono::nanoseconds>(age)};
}

Recollection PlannerService::judge_remembered() {
  if (planners_.size() == 1) return Recollection::kCounts;
  const auto judged =
      judge_recollection(remembered_->mandate, std::chrono::nanoseconds(remembered_->until_ns), duty_, last_command());
  if (judged != Recollection::kUnknown || !in_charge_) {
    undecided_since_.reset();
    return judged;
  }
  // Who is in charge answers goals, also when the driver is never heard.
  if (!undecided_since_) undecided_since_ = now_;
  return now_ - *undecided_since_ > kLongestWait ? Recollection::kOutdated : judged;
}

// Where another planner may have had the arm since, its goals are that one's to tell.
void PlannerService::resume_goal() {
  if (!remembered_) return;
  const Recollection judged = judge_remembered();
  if (judged == Recollection::kUnknown) return;
  GoalMemory::Remembered remembered = *std::exchange(remembered_, std::nullopt);
  if (judged == Recollection::kOutdated) {
    remembered.account.active.reset();
    remembered.account.ends.clear();
  }
  has_news_ = true;
  const auto ago = std::chrono::nanoseconds(std::max<std::int64_t>(0, stamp_now() - remembered.stamp_ns));
  if (!desk_.resume(remembered.account, ago, now_)) return;
  controller_.set_goal(desk_.q_goal());
  log_info("resumes a goal", {{"arm", name_}, {"goal", remembered.account.active->goal}});
}

// Before anything of it is told: what was acknowledged is never forgotten. What has ended is told again instead. Who
// stands by remembers, too: the arm may have no other planner tomorrow.
void PlannerService::remember_goals() {
  if (!memory_ || remembered_) return;
  const std::int64_t now_ns = stamp_now();
  if (std::exchange(has_news_, false)) memory_->remember({desk_.account(now_), duty_.mandate(), now_ns, now_ns});
  memory_->confirm(now_ns);
}

}  // namespace hecaton::services
