#include "services/planner/failover.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <iterator>
#include <stdexcept>

#include "services/bus/wire_rules.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/process_info.hpp"

namespace hecaton::services {
namespace {

using Name = std::array<char, GoalSnapshot::kLongestName + 1>;  // ends with 0

void write(Name& name, const std::string& text) {
  name.fill(0);
  std::copy_n(text.begin(), std::min(text.size(), GoalSnapshot::kLongestName), name.begin());
}

/// Goals with deferred statuses: more than a planner keeps on the bus.
constexpr std::size_t kDeferred = 64;

std::unique_ptr<GoalCheckpoint> checkpoint_in(const std::string& path, int joints) {
  try {
    return std::make_unique<GoalCheckpoint>(path, joints);
  } catch (const std::runtime_error& error) {
    log_warning("goals are not saved and will be lost when this process ends", {{"reason", error.what()}});
    return nullptr;
  }
}

std::optional<LastCommand> last_command(const std::optional<ArmView::ReceivedState>& own) {
  constexpr double kForEver = 1e9;  // [s]
  if (!own) return std::nullopt;
  const std::chrono::duration<double> age(std::min(own->command_age, kForEver));
  return LastCommand{own->term, own->at.time_since_epoch() - std::chrono::duration_cast<std::chrono::nanoseconds>(age)};
}

}  // namespace

struct GoalCheckpoint::Slot {
  std::uint64_t number;  ///< counts saves, from 1; 0: nothing, or half written
  std::uint64_t layout;  ///< layout_of(its joints)
  std::uint64_t term;
  std::int64_t stamp_ns;
  std::int64_t until_ns;
  std::uint64_t has_active;
  std::uint64_t sequence_number;
  double time_limit;
  double elapsed;
  double trajectory_time;
  std::array<double, planner::kMaxJoints> q_goal;
  std::uint64_t has_tool;
  std::uint64_t free_rotation;
  std::array<double, 16> X_WT;
  double position_tolerance;
  double orientation_tolerance;
  std::uint64_t results;
  std::array<std::uint64_t, GoalSnapshot::kResults> states;
  std::uint64_t handled;
  std::array<std::uint64_t, GoalSnapshot::kHandled> digests;
  Name planner, goal, client;
  std::array<Name, GoalSnapshot::kResults> ended;

  /// Distinguishes slots of other arms and of other versions of this struct.
  static std::uint64_t layout_of(int joints) { return sizeof(Slot) << 8U | static_cast<unsigned>(joints); }

  [[nodiscard]] bool whole(int joints) const {
    const bool names_end = planner.back() == 0 && goal.back() == 0 && client.back() == 0 &&
                           std::all_of(ended.begin(), ended.end(), [](const Name& name) { return name.back() == 0; });
    return number > 0 && layout == layout_of(joints) && names_end && results <= GoalSnapshot::kResults &&
           handled <= GoalSnapshot::kHandled && std::isfinite(elapsed) && std::isfinite(time_limit) &&
           std::isfinite(trajectory_time) &&
           std::all_of(q_goal.begin(), q_goal.begin() + joints, [](double q) { return std::isfinite(q); }) &&
           free_rotation <= static_cast<std::uint64_t>(planner::FreeRotation::kAll) &&
           std::all_of(X_WT.begin(), X_WT.end(), [](double value) { return std::isfinite(value); }) &&
           std::isfinite(position_tolerance) && std::isfinite(orientation_tolerance);
  }
};

GoalCheckpoint::GoalCheckpoint(const std::string& path, int joints)
    : joints_(joints),
      file_(path, 2 * sizeof(Slot), "what the planner must not forget"),
      slots_(static_cast<Slot*>(file_.data())) {
  if (const Slot* last = newest()) number_ = last->number;
}

const GoalCheckpoint::Slot* GoalCheckpoint::newest() const {
  if (slots_ == nullptr) return nullptr;
  const Slot& slot = slots_[0].number > slots_[1].number ? slots_[0] : slots_[1];
  return slot.whole(joints_) ? &slot : nullptr;
}

std::optional<GoalCheckpoint::Saved> GoalCheckpoint::load() const {
  const Slot* slot = newest();
  if (slot == nullptr || !bus::is_usable_term(slot->term)) return std::nullopt;
  Saved what;
  what.lease = {slot->planner.data(), slot->term};
  what.stamp_ns = slot->stamp_ns;
  what.until_ns = slot->until_ns;
  if (slot->has_active != 0) {
    what.snapshot.active = GoalSnapshot::Active{
        slot->goal.data(), slot->client.data(), slot->sequence_number,
        slot->time_limit,  slot->elapsed,       Eigen::Map<const Eigen::VectorXd>(slot->q_goal.data(), joints_)};
    what.snapshot.active->trajectory_time = slot->trajectory_time;
    if (slot->has_tool != 0) {
      planner::ToolGoal& tool = what.snapshot.active->tool.emplace();
      tool.X_WT.matrix() = Eigen::Map<const Eigen::Matrix4d>(slot->X_WT.data());
      tool.free_rotation = static_cast<planner::FreeRotation>(slot->free_rotation);
      tool.position_tolerance = slot->position_tolerance;
      tool.orientation_tolerance = slot->orientation_tolerance;
    }
  }
  for (std::size_t i = 0; i < slot->results; ++i) {
    what.snapshot.results.push_back({slot->ended[i].data(), static_cast<msg::GoalState>(slot->states[i])});
  }
  what.snapshot.handled.assign(slot->digests.begin(),
                               slot->digests.begin() + static_cast<std::ptrdiff_t>(slot->handled));
  return what;
}

void GoalCheckpoint::save(const Saved& what) {
  if (slots_ == nullptr) return;
  Slot& slot = slots_[++number_ % 2];
  const std::atomic_ref<std::uint64_t> number(slot.number);
  number.store(0, std::memory_order_seq_cst);  // until the slot is complete, readers use the other one
  slot.layout = Slot::layout_of(joints_);
  slot.term = what.lease.term;
  slot.stamp_ns = what.stamp_ns;
  slot.until_ns = what.until_ns;
  write(slot.planner, what.lease.planner);
  const GoalSnapshot& snapshot = what.snapshot;
  const GoalSnapshot::Active active =
      snapshot.active.value_or(GoalSnapshot::Active{{}, {}, 0, 0.0, 0.0, planner::JointVector::Zero(joints_)});
  slot.has_active = snapshot.active ? 1 : 0;
  write(slot.goal, active.goal);
  write(slot.client, active.client);
  slot.sequence_number = active.sequence_number;
  slot.time_limit = active.time_limit;
  slot.elapsed = active.elapsed;
  slot.trajectory_time = active.trajectory_time;
  std::copy(active.q_goal.begin(), active.q_goal.end(), slot.q_goal.begin());
  const planner::ToolGoal tool = active.tool.value_or(planner::ToolGoal{});
  slot.has_tool = active.tool ? 1 : 0;
  slot.free_rotation = static_cast<std::uint64_t>(tool.free_rotation);
  Eigen::Map<Eigen::Matrix4d>(slot.X_WT.data()) = tool.X_WT.matrix();
  slot.position_tolerance = tool.position_tolerance;
  slot.orientation_tolerance = tool.orientation_tolerance;
  slot.results = std::min(snapshot.results.size(), GoalSnapshot::kResults);
  for (std::size_t i = 0; i < slot.results; ++i) {
    write(slot.ended[i], snapshot.results[i].goal);
    slot.states[i] = static_cast<std::uint64_t>(snapshot.results[i].state);
  }
  slot.handled = std::min(snapshot.handled.size(), GoalSnapshot::kHandled);
  std::copy_n(snapshot.handled.begin(), slot.handled, slot.digests.begin());
  number.store(number_, std::memory_order_release);
}

void GoalCheckpoint::confirm(std::int64_t now_ns) {
  if (slots_ == nullptr || number_ == 0) return;
  std::atomic_ref(slots_[number_ % 2].until_ns).store(now_ns, std::memory_order_relaxed);
}

CheckpointValidity judge_checkpoint(const ArmLease& under, std::chrono::nanoseconds until, const FailoverRole& role,
                                    const std::optional<LastCommand>& last) {
  const ArmLease& newest = role.lease();
  if (newest.term == 0) return CheckpointValidity::kUndecided;
  // A lease is never granted again: no other planner has been in charge.
  if (newest == under && role.in_charge()) return CheckpointValidity::kValid;
  if (!last) return CheckpointValidity::kUndecided;
  // A planner in charge always sends commands, also for an arm at rest.
  if (last->term != under.term || last->at > until + kSimultaneousLoss) return CheckpointValidity::kOutdated;
  if (newest == under || role.in_charge()) return CheckpointValidity::kValid;
  return CheckpointValidity::kUndecided;  // another planner was put in charge and has sent no command yet: it may be
                                          // dead
}

StatusAction action_for(const msg::GoalStatus& status, const FailoverRole& role, bool ready) {
  if (!ready || role.term() == 0) return StatusAction::kDefer;
  // The status may be the first sign that this planner was replaced.
  if (role.in_charge()) return status.term() > role.term() ? StatusAction::kDefer : StatusAction::kIgnore;
  // A final status is always valid. Another status of an earlier term may be outdated: the bus also delivers the last
  // status of a planner that is now the standby.
  return is_final(status.state()) || status.term() >= role.term() ? StatusAction::kApply : StatusAction::kIgnore;
}

void UnpublishedResults::keep(std::vector<msg::GoalStatus> statuses) {
  for (msg::GoalStatus& status : statuses) {
    const bool published = std::find(published_.begin(), published_.end(), status.goal()) != published_.end();
    if (is_final(status.state()) && !published) unpublished_.push_back(std::move(status));
  }
  while (unpublished_.size() > kKept) unpublished_.pop_front();
}

void UnpublishedResults::on_published(const msg::GoalStatus& status) {
  if (!is_final(status.state())) return;
  std::erase_if(unpublished_, [&](const msg::GoalStatus& own) { return own.goal() == status.goal(); });
  published_.push_back(status.goal());
  if (published_.size() > kKept) published_.pop_front();
}

std::vector<GoalSnapshot::Result> UnpublishedResults::results() const {
  std::vector<GoalSnapshot::Result> results;
  for (const msg::GoalStatus& status : unpublished_) results.push_back({status.goal(), status.state()});
  return results;
}

std::vector<msg::GoalStatus> UnpublishedResults::take() {
  auto left = std::exchange(unpublished_, {});
  return {std::make_move_iterator(left.begin()), std::make_move_iterator(left.end())};
}

FailoverParticipant::FailoverParticipant(Identity identity, const std::string& checkpoint, int joints)
    : identity_(std::move(identity)),
      role_(identity_.node, identity_.first),
      in_charge_(identity_.alone),
      was_in_charge_(identity_.alone),
      checkpoint_(checkpoint_in(checkpoint, joints)),
      saved_(checkpoint_ ? checkpoint_->load() : std::nullopt) {}

bool FailoverParticipant::update_lease(const ArmLease& ordered) {
  role_.update(ordered);
  return identity_.alone || role_.in_charge();
}

void FailoverParticipant::update(const Inputs& inputs, GoalManager& goals) {
  for (const msg::GoalStatus& status : inputs.statuses) handle(status, goals, inputs.now);
  update_role(inputs);
  resume(inputs, goals);
  if (!ready() || role_.lease() == handled_under_) return;
  handled_under_ = role_.lease();
  changed_ = true;
  for (const msg::GoalStatus& status : std::exchange(deferred_, {})) handle(status, goals, inputs.now);
}

void FailoverParticipant::handle(const msg::GoalStatus& status, GoalManager& goals, Clock::time_point now) {
  if (status.arm() != identity_.arm || status.node() == identity_.node) return;
  const StatusAction what = action_for(status, role_, ready());
  if (what == StatusAction::kIgnore) return;
  if (what == StatusAction::kDefer) {
    std::erase_if(deferred_, [&](const msg::GoalStatus& known) { return known.goal() == status.goal(); });
    deferred_.push_back(status);
    if (deferred_.size() > kDeferred) deferred_.pop_front();
    return;
  }
  unpublished_.on_published(status);
  goals.follow(status, now);
  changed_ = true;
}

void FailoverParticipant::update_role(const Inputs& inputs) {
  if (inputs.own) role_.update_from_driver(inputs.own->lease);
  was_in_charge_ = in_charge_;
  in_charge_ = update_lease(inputs.ordered);
  if (in_charge_ == was_in_charge_) return;
  log_info(in_charge_ ? "planner took charge" : "planner stands by", {{"arm", identity_.arm}, {"term", role_.term()}});
}

CheckpointValidity FailoverParticipant::validity_of_saved(const Inputs& inputs) {
  if (identity_.alone) return CheckpointValidity::kValid;
  const auto judged =
      judge_checkpoint(saved_->lease, std::chrono::nanoseconds(saved_->until_ns), role_, last_command(inputs.own));
  if (judged != CheckpointValidity::kUndecided || !in_charge_) {
    undecided_since_.reset();
    return judged;
  }
  // The planner in charge must answer goals, even if it receives no state of the driver.
  if (!undecided_since_) undecided_since_ = inputs.now;
  return inputs.now - *undecided_since_ > kLongestWait ? CheckpointValidity::kOutdated : judged;
}

// Goals of an outdated checkpoint belong to the planner that has been in charge since.
void FailoverParticipant::resume(const Inputs& inputs, GoalManager& goals) {
  if (ready()) return;
  const CheckpointValidity judged = validity_of_saved(inputs);
  if (judged == CheckpointValidity::kUndecided) return;
  GoalCheckpoint::Saved saved = *std::exchange(saved_, std::nullopt);
  if (judged == CheckpointValidity::kOutdated) {
    saved.snapshot.active.reset();
    saved.snapshot.results.clear();
  }
  changed_ = true;
  const auto ago = std::chrono::nanoseconds(std::max<std::int64_t>(0, stamp_now() - saved.stamp_ns));
  if (!goals.resume(saved.snapshot, ago, inputs.now)) return;
  log_info("goal resumed", {{"arm", identity_.arm}, {"goal", saved.snapshot.active->goal}});
}

std::vector<msg::GoalStatus> FailoverParticipant::release(std::vector<msg::GoalStatus> statuses, GoalManager& goals,
                                                          Clock::time_point now) {
  changed_ = changed_ || !statuses.empty();
  if (!in_charge_) {
    unpublished_.keep(std::move(statuses));
    goals.keep_results(unpublished_.results());
    save(goals, now);
    return {};
  }
  save(goals, now);
  std::vector<msg::GoalStatus> all = unpublished_.take();
  all.insert(all.end(), std::make_move_iterator(statuses.begin()), std::make_move_iterator(statuses.end()));
  for (msg::GoalStatus& status : all) status.term(role_.term());
  return all;
}

// Saves before publishing, so that no published status is lost; final statuses may be published twice instead. A
// standby planner saves, too: it may be the only planner after the next restart.
void FailoverParticipant::save(const GoalManager& goals, Clock::time_point now) {
  if (!checkpoint_ || !ready()) return;
  const std::int64_t now_ns = stamp_now();
  if (std::exchange(changed_, false)) checkpoint_->save({goals.snapshot(now), role_.lease(), now_ns, now_ns});
  checkpoint_->confirm(now_ns);
}

}  // namespace hecaton::services
