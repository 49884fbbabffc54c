#include "services/arm_driver/devices/ros2_control/motion_watch.hpp"

#include <algorithm>

namespace hecaton::device::ros2_control {
namespace {

/// Between samples, and the time in which set-points are compared.
constexpr std::chrono::milliseconds kStep{20};
constexpr std::chrono::seconds kWindow{1};
/// Set-points that have moved this far must have moved the arm [rad | m], by this share of it.
constexpr double kMoved = 0.05;
constexpr double kShare = 0.2;
/// An arm may begin to move after this many times its lag, and some time.
constexpr double kLags = 3.0;
constexpr double kBegin = 0.2;  // [s]

}  // namespace

void MotionWatch::add(Clock::time_point now, const JointVector& set_point, const JointVector& measured, double delay) {
  if (!samples_.empty() && now - samples_.back().at < kStep) return;
  answer_ = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kLags * delay + kBegin));
  samples_.push_back({now, set_point, measured});
  while (now - samples_.front().at > kWindow + answer_) samples_.pop_front();
}

std::optional<Eigen::Index> MotionWatch::idle_joint() const {
  if (samples_.empty()) return std::nullopt;
  JointVector least = samples_.front().set_point;
  JointVector most = least;
  JointVector lowest = samples_.front().measured;
  JointVector highest = lowest;
  for (const Sample& sample : samples_) {
    lowest = lowest.cwiseMin(sample.measured);
    highest = highest.cwiseMax(sample.measured);
    if (samples_.back().at - sample.at < answer_) continue;
    least = least.cwiseMin(sample.set_point);
    most = most.cwiseMax(sample.set_point);
  }
  for (Eigen::Index joint = 0; joint < least.size(); ++joint) {
    const double moved = most[joint] - least[joint];
    if (moved > kMoved && highest[joint] - lowest[joint] < kShare * moved) return joint;
  }
  return std::nullopt;
}

}  // namespace hecaton::device::ros2_control
