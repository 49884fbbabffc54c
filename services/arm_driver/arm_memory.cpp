#include "services/arm_driver/arm_memory.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace hecaton::services {

struct ArmMemory::Slot {
  std::uint64_t number;  ///< counts what is remembered, from 1; 0: nothing, or half written
  std::uint64_t layout;  ///< layout_of(its joints)
  std::array<double, planner::kMaxJoints> q;
  std::uint64_t term;
  std::array<char, 256> planner;  ///< ends with 0

  /// Tells slots of another arm, and of another edition of this struct, from ours.
  static std::uint64_t layout_of(int joints) { return sizeof(Slot) << 8U | static_cast<unsigned>(joints); }
};

ArmMemory::ArmMemory(const std::string& path, int joints)
    : joints_(joints),
      file_(path, 2 * sizeof(Slot), "what the driver must not forget"),
      slots_(static_cast<Slot*>(file_.data())) {
  if (const Slot* last = newest()) number_ = last->number;
}

const ArmMemory::Slot* ArmMemory::newest() const {
  if (slots_ == nullptr) return nullptr;
  const Slot& slot = slots_[0].number > slots_[1].number ? slots_[0] : slots_[1];
  const bool whole = slot.number > 0 && slot.layout == Slot::layout_of(joints_) && slot.planner.back() == 0 &&
                     std::all_of(slot.q.begin(), slot.q.begin() + joints_, [](double q) { return std::isfinite(q); });
  return whole ? &slot : nullptr;
}

std::optional<ArmMemory::Remembered> ArmMemory::recall() const {
  const Slot* slot = newest();
  if (slot == nullptr) return std::nullopt;
  return Remembered{Eigen::Map<const Eigen::VectorXd>(slot->q.data(), joints_), {slot->planner.data(), slot->term}};
}

void ArmMemory::remember(const planner::JointVector& q, const ArmLease& mandate) {
  if (slots_ == nullptr) return;
  Slot& slot = slots_[++number_ % 2];
  const std::atomic_ref<std::uint64_t> number(slot.number);
  number.store(0, std::memory_order_seq_cst);  // whoever reads now takes the other one
  slot.layout = Slot::layout_of(joints_);
  std::copy(q.begin(), q.end(), slot.q.begin());
  slot.term = mandate.term;
  slot.planner.fill(0);
  if (mandate.planner.size() < slot.planner.size()) std::ranges::copy(mandate.planner, slot.planner.begin());
  number.store(number_, std::memory_order_release);
}

}  // namespace hecaton::services
