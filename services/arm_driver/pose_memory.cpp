#include "services/arm_driver/pose_memory.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace hecaton::services {

struct PoseMemory::Slot {
  std::uint64_t number;  ///< counts what is remembered, from 1; 0: nothing, or half written
  std::uint64_t joints;
  std::array<double, planner::kMaxJoints> q;
};

PoseMemory::PoseMemory(const std::string& path, int joints) : joints_(joints) {
  if (path.empty()) return;
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  void* memory = MAP_FAILED;
  if (file >= 0 && ::ftruncate(file, 2 * sizeof(Slot)) == 0) {
    memory = ::mmap(nullptr, 2 * sizeof(Slot), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  }
  const int error = errno;
  if (file >= 0) ::close(file);
  if (memory == MAP_FAILED) {
    throw std::runtime_error(path + ": the arm's pose cannot be remembered there: " + std::strerror(error));
  }
  slots_ = static_cast<Slot*>(memory);
  if (const Slot* last = newest()) number_ = last->number;
}

PoseMemory::~PoseMemory() {
  if (slots_ != nullptr) ::munmap(slots_, 2 * sizeof(Slot));
}

const PoseMemory::Slot* PoseMemory::newest() const {
  if (slots_ == nullptr) return nullptr;
  const Slot& slot = slots_[0].number > slots_[1].number ? slots_[0] : slots_[1];
  const auto joints = static_cast<std::uint64_t>(joints_);
  const bool whole = slot.number > 0 && slot.joints == joints &&
                     std::all_of(slot.q.begin(), slot.q.begin() + joints_, [](double q) { return std::isfinite(q); });
  return whole ? &slot : nullptr;
}

planner::JointVector PoseMemory::recall() const {
  const Slot* slot = newest();
  if (slot == nullptr) return {};
  return Eigen::Map<const Eigen::VectorXd>(slot->q.data(), joints_);
}

void PoseMemory::remember(const planner::JointVector& q) {
  if (slots_ == nullptr) return;
  Slot& slot = slots_[++number_ % 2];
  const std::atomic_ref<std::uint64_t> number(slot.number);
  number.store(0, std::memory_order_seq_cst);  // whoever reads now takes the other one
  slot.joints = static_cast<std::uint64_t>(joints_);
  std::copy(q.begin(), q.end(), slot.q.begin());
  number.store(number_, std::memory_order_release);
}

}  // namespace hecaton::services
