#include "services/planner/failover.hpp"

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "services/runtime/goal_state.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

/// Goals with statuses that wait to be judged: as many as a planner keeps on the bus, and some.
constexpr std::size_t kWaiting = 64;

std::unique_ptr<GoalCheckpoint> checkpoint_in(const std::string& path, int joints) {
  try {
    return std::make_unique<GoalCheckpoint>(path, joints);
  } catch (const std::runtime_error& error) {
    log_warning("goals are not saved: they are lost when this process ends", {{"reason", error.what()}});
    return nullptr;
  }
}

std::optional<LastCommand> last_command(const std::optional<ArmView::Heard>& own) {
  constexpr double kForEver = 1e9;  // [s]
  if (!own) return std::nullopt;
  const std::chrono::duration<double> age(std::min(own->command_age, kForEver));
  return LastCommand{own->term, own->at.time_since_epoch() - std::chrono::duration_cast<std::chrono::nanoseconds>(age)};
}

}  // namespace

Recollection judge_recollection(const ArmLease& under, std::chrono::nanoseconds until, const Duty& duty,
                                const std::optional<LastCommand>& last) {
  const ArmLease& newest = duty.mandate();
  if (newest.term == 0) return Recollection::kUnknown;
  // Mandates never return: no other planner can have had the arm.
  if (newest == under && duty.in_charge()) return Recollection::kCounts;
  if (!last) return Recollection::kUnknown;
  // A planner in charge commands, also an arm that stands.
  if (last->term != under.term || last->at > until + kTogether) return Recollection::kOutdated;
  if (newest == under || duty.in_charge()) return Recollection::kCounts;
  return Recollection::kUnknown;  // another was put in charge since, and has not begun: perhaps it is dead
}

Heed heed(const msg::GoalStatus& status, const Duty& duty, bool ready) {
  if (!ready || duty.term() == 0) return Heed::kLater;
  // A planner that was replaced may learn it here first.
  if (duty.in_charge()) return status.term() > duty.term() ? Heed::kLater : Heed::kIgnore;
  // An end is an end. But what was under way in an earlier term of the other planner need not be any more: the bus also
  // delivers the last status of a planner that stands by now.
  return is_over(status.state()) || status.term() >= duty.term() ? Heed::kFollow : Heed::kIgnore;
}

void UnpublishedEnds::keep(std::vector<msg::GoalStatus> statuses) {
  for (msg::GoalStatus& status : statuses) {
    const bool published = std::find(published_.begin(), published_.end(), status.goal()) != published_.end();
    if (is_over(status.state()) && !published) unpublished_.push_back(std::move(status));
  }
  while (unpublished_.size() > kKept) unpublished_.pop_front();
}

void UnpublishedEnds::heard(const msg::GoalStatus& status) {
  if (!is_over(status.state())) return;
  std::erase_if(unpublished_, [&](const msg::GoalStatus& own) { return own.goal() == status.goal(); });
  published_.push_back(status.goal());
  if (published_.size() > kKept) published_.pop_front();
}

std::vector<GoalSnapshot::End> UnpublishedEnds::ends() const {
  std::vector<GoalSnapshot::End> ends;
  for (const msg::GoalStatus& status : unpublished_) ends.push_back({status.goal(), status.state()});
  return ends;
}

std::vector<msg::GoalStatus> UnpublishedEnds::take() {
  auto left = std::exchange(unpublished_, {});
  return {std::make_move_iterator(left.begin()), std::make_move_iterator(left.end())};
}

FailoverParticipant::FailoverParticipant(Identity identity, const std::string& checkpoint, int joints)
    : identity_(std::move(identity)),
      duty_(identity_.node, identity_.first),
      in_charge_(identity_.alone),
      was_in_charge_(identity_.alone),
      checkpoint_(checkpoint_in(checkpoint, joints)),
      saved_(checkpoint_ ? checkpoint_->load() : std::nullopt) {}

bool FailoverParticipant::hear(const ArmLease& ordered) {
  duty_.hear(ordered);
  return identity_.alone || duty_.in_charge();
}

void FailoverParticipant::update(const News& news, GoalManager& goals) {
  for (const msg::GoalStatus& status : news.statuses) judge(status, goals, news.now);
  take_duty(news);
  resume(news, goals);
  if (!ready() || duty_.mandate() == judged_under_) return;
  judged_under_ = duty_.mandate();
  changed_ = true;
  for (const msg::GoalStatus& status : std::exchange(waiting_, {})) judge(status, goals, news.now);
}

void FailoverParticipant::judge(const msg::GoalStatus& status, GoalManager& goals, Clock::time_point now) {
  if (status.arm() != identity_.arm || status.node() == identity_.node) return;
  const Heed what = heed(status, duty_, ready());
  if (what == Heed::kIgnore) return;
  if (what == Heed::kLater) {
    std::erase_if(waiting_, [&](const msg::GoalStatus& known) { return known.goal() == status.goal(); });
    waiting_.push_back(status);
    if (waiting_.size() > kWaiting) waiting_.pop_front();
    return;
  }
  unpublished_.heard(status);
  goals.follow(status, now);
  changed_ = true;
}

void FailoverParticipant::take_duty(const News& news) {
  if (news.own) duty_.hear_driver(news.own->mandate);
  was_in_charge_ = in_charge_;
  in_charge_ = hear(news.ordered);
  if (in_charge_ == was_in_charge_) return;
  log_info(in_charge_ ? "is in charge" : "stands by", {{"arm", identity_.arm}, {"term", duty_.term()}});
}

Recollection FailoverParticipant::judge_saved(const News& news) {
  if (identity_.alone) return Recollection::kCounts;
  const auto judged =
      judge_recollection(saved_->mandate, std::chrono::nanoseconds(saved_->until_ns), duty_, last_command(news.own));
  if (judged != Recollection::kUnknown || !in_charge_) {
    undecided_since_.reset();
    return judged;
  }
  // The planner in charge answers goals, also when the driver is never heard.
  if (!undecided_since_) undecided_since_ = news.now;
  return news.now - *undecided_since_ > kLongestWait ? Recollection::kOutdated : judged;
}

// Where another planner may have had the arm since, its goals are that planner's to publish.
void FailoverParticipant::resume(const News& news, GoalManager& goals) {
  if (ready()) return;
  const Recollection judged = judge_saved(news);
  if (judged == Recollection::kUnknown) return;
  GoalCheckpoint::Saved saved = *std::exchange(saved_, std::nullopt);
  if (judged == Recollection::kOutdated) {
    saved.snapshot.active.reset();
    saved.snapshot.ends.clear();
  }
  changed_ = true;
  const auto ago = std::chrono::nanoseconds(std::max<std::int64_t>(0, stamp_now() - saved.stamp_ns));
  if (!goals.resume(saved.snapshot, ago, news.now)) return;
  log_info("resumes a goal", {{"arm", identity_.arm}, {"goal", saved.snapshot.active->goal}});
}

std::vector<msg::GoalStatus> FailoverParticipant::release(std::vector<msg::GoalStatus> statuses, GoalManager& goals,
                                                          Clock::time_point now) {
  changed_ = changed_ || !statuses.empty();
  if (!in_charge_) {
    unpublished_.keep(std::move(statuses));
    goals.owe_ends(unpublished_.ends());
    save(goals, now);
    return {};
  }
  save(goals, now);
  std::vector<msg::GoalStatus> all = unpublished_.take();
  all.insert(all.end(), std::make_move_iterator(statuses.begin()), std::make_move_iterator(statuses.end()));
  for (msg::GoalStatus& status : all) status.term(duty_.term());
  return all;
}

// Before anything of it is published: a status that a client has is never forgotten. What has ended is published again
// instead. A standby saves, too: the arm may have no other planner tomorrow.
void FailoverParticipant::save(const GoalManager& goals, Clock::time_point now) {
  if (!checkpoint_ || !ready()) return;
  const std::int64_t now_ns = stamp_now();
  if (std::exchange(changed_, false)) checkpoint_->save({goals.snapshot(now), duty_.mandate(), now_ns, now_ns});
  checkpoint_->confirm(now_ns);
}

}  // namespace hecaton::services
