#include "services/planner/goal_checkpoint.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace hecaton::services {
namespace {

using Name = std::array<char, GoalSnapshot::kLongestName + 1>;  // ends with 0

void write(Name& name, const std::string& text) {
  name.fill(0);
  std::copy_n(text.begin(), std::min(text.size(), GoalSnapshot::kLongestName), name.begin());
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
  std::array<double, planner::kMaxJoints> q_goal;
  std::uint64_t ends;
  std::array<std::uint64_t, GoalSnapshot::kEnds> states;
  std::uint64_t handled;
  std::array<std::uint64_t, GoalSnapshot::kHandled> digests;
  Name planner, goal, client;
  std::array<Name, GoalSnapshot::kEnds> ended;

  /// Tells slots of another arm, and of another edition of this struct, from ours.
  static std::uint64_t layout_of(int joints) { return sizeof(Slot) << 8U | static_cast<unsigned>(joints); }

  [[nodiscard]] bool whole(int joints) const {
    const bool names_end = planner.back() == 0 && goal.back() == 0 && client.back() == 0 &&
                           std::all_of(ended.begin(), ended.end(), [](const Name& name) { return name.back() == 0; });
    return number > 0 && layout == layout_of(joints) && names_end && ends <= GoalSnapshot::kEnds &&
           handled <= GoalSnapshot::kHandled && std::isfinite(elapsed) && std::isfinite(time_limit) &&
           std::all_of(q_goal.begin(), q_goal.begin() + joints, [](double q) { return std::isfinite(q); });
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
  if (slot == nullptr) return std::nullopt;
  Saved what;
  what.mandate = {slot->planner.data(), slot->term};
  what.stamp_ns = slot->stamp_ns;
  what.until_ns = slot->until_ns;
  if (slot->has_active != 0) {
    what.snapshot.active = GoalSnapshot::Active{
        slot->goal.data(), slot->client.data(), slot->sequence_number,
        slot->time_limit,  slot->elapsed,       Eigen::Map<const Eigen::VectorXd>(slot->q_goal.data(), joints_)};
  }
  for (std::size_t i = 0; i < slot->ends; ++i) {
    what.snapshot.ends.push_back({slot->ended[i].data(), static_cast<msg::GoalState>(slot->states[i])});
  }
  what.snapshot.handled.assign(slot->digests.begin(),
                               slot->digests.begin() + static_cast<std::ptrdiff_t>(slot->handled));
  return what;
}

void GoalCheckpoint::save(const Saved& what) {
  if (slots_ == nullptr) return;
  Slot& slot = slots_[++number_ % 2];
  const std::atomic_ref<std::uint64_t> number(slot.number);
  number.store(0, std::memory_order_seq_cst);  // whoever reads now takes the other one
  slot.layout = Slot::layout_of(joints_);
  slot.term = what.mandate.term;
  slot.stamp_ns = what.stamp_ns;
  slot.until_ns = what.until_ns;
  write(slot.planner, what.mandate.planner);
  const GoalSnapshot& snapshot = what.snapshot;
  const GoalSnapshot::Active active =
      snapshot.active.value_or(GoalSnapshot::Active{{}, {}, 0, 0.0, 0.0, planner::JointVector::Zero(joints_)});
  slot.has_active = snapshot.active ? 1 : 0;
  write(slot.goal, active.goal);
  write(slot.client, active.client);
  slot.sequence_number = active.sequence_number;
  slot.time_limit = active.time_limit;
  slot.elapsed = active.elapsed;
  std::copy(active.q_goal.begin(), active.q_goal.end(), slot.q_goal.begin());
  slot.ends = std::min(snapshot.ends.size(), GoalSnapshot::kEnds);
  for (std::size_t i = 0; i < slot.ends; ++i) {
    write(slot.ended[i], snapshot.ends[i].goal);
    slot.states[i] = static_cast<std::uint64_t>(snapshot.ends[i].state);
  }
  slot.handled = std::min(snapshot.handled.size(), GoalSnapshot::kHandled);
  std::copy_n(snapshot.handled.begin(), slot.handled, slot.digests.begin());
  number.store(number_, std::memory_order_release);
}

void GoalCheckpoint::confirm(std::int64_t now_ns) {
  if (slots_ == nullptr || number_ == 0) return;
  std::atomic_ref(slots_[number_ % 2].until_ns).store(now_ns, std::memory_order_relaxed);
}

}  // namespace hecaton::services
