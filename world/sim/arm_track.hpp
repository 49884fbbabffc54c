#pragma once
/// An arm as measured, and its even way through one step of the world.

#include <span>
#include <vector>

#include "world/model/obstacle_motion.hpp"
#include "world/model/pose.hpp"

namespace hecaton::world {

class ArmTrack {
 public:
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] std::span<const Pose> X_WL() const { return X_WL_; }
  [[nodiscard]] const Pose& X_WT() const { return X_WT_; }
  /// Over the last step.
  [[nodiscard]] const Twist& tool_velocity() const { return tool_velocity_; }

  void measure(std::span<const Pose> X_WL, const Pose& X_WT) {
    X_WL_.assign(X_WL.begin(), X_WL.end());
    X_WT_ = X_WT;
    if (known_) return;
    X_WL_before_ = X_WL_;
    X_WT_before_ = X_WT_;
    known_ = true;
  }

  /// `elapsed` [s] after the beginning of a step of dt > 0 [s] that ends where the arm was last measured.
  [[nodiscard]] MotionState link_at(int link, double dt, double elapsed) const {
    return between(X_WL_before_[link], X_WL_[link], dt, elapsed);
  }
  [[nodiscard]] MotionState tool_at(double dt, double elapsed) const {
    return between(X_WT_before_, X_WT_, dt, elapsed);
  }

  void end_step(double dt) {
    if (!known_ || dt <= 0.0) return;
    tool_velocity_ = twist_between(X_WT_before_, X_WT_, dt);
    X_WL_before_ = X_WL_;
    X_WT_before_ = X_WT_;
  }

 private:
  static MotionState between(const Pose& from, const Pose& to, double dt, double elapsed) {
    const Twist velocity = twist_between(from, to, dt);
    return {extrapolate(from, velocity, elapsed), velocity};
  }

  bool known_ = false;
  std::vector<Pose> X_WL_;
  Pose X_WT_ = Pose::Identity();
  std::vector<Pose> X_WL_before_;  ///< at the last step
  Pose X_WT_before_ = Pose::Identity();
  Twist tool_velocity_;
};

/// Where something held at X_TO is and how it moves, with the tool.
[[nodiscard]] inline MotionState carried(const MotionState& tool, const Pose& X_TO) {
  const Pose X_WO = tool.X_WO * X_TO;
  return {X_WO, {tool.velocity.at(X_WO.translation(), tool.X_WO.translation()), tool.velocity.angular}};
}

}  // namespace hecaton::world
