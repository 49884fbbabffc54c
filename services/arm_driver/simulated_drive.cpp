#include "services/arm_driver/simulated_drive.hpp"

#include <cstdio>
#include <utility>

namespace hecaton::services {
namespace {

/// Which joint is farthest from where it is told to be.
std::string far_text(const planner::JointVector& told, const planner::JointVector& is) {
  Eigen::Index joint = 0;
  (told - is).cwiseAbs().maxCoeff(&joint);
  char text[128];
  std::snprintf(text, sizeof text, "the set-point is too far away: joint %d is at %.3f and told to be at %.3f",
                static_cast<int>(joint) + 1, is[joint], told[joint]);
  return text;
}

}  // namespace

SimulatedDrive::SimulatedDrive(planner::JointLimits limits, const planner::JointVector& start, double command_timeout)
    : arm_(std::move(limits), start, command_timeout),
      gate_(static_cast<int>(start.size())),
      command_timeout_(command_timeout),
      why_("no supervisor was heard yet") {}

void SimulatedDrive::order(msg::Mode order, const std::string& why) {
  order_ = order;
  why_ = why;
  if (order != msg::Mode::MODE_RUN) arm_.stop();
}

// A command counts as accepted also while the arm is held, so that its sender knows that it is heard.
Verdict SimulatedDrive::command(const msg::ArmCommand& command) {
  const Verdict verdict = gate_.judge(command);
  if (verdict != Verdict::kAccepted) return verdict;
  if (order_ == msg::Mode::MODE_RUN && !arm_.command(gate_.q(), gate_.qd(), gate_.period())) {
    complaint_ = far_text(gate_.q(), arm_.q());
    ++too_far_;
    return Verdict::kTooFar;
  }
  complaint_.clear();
  commanded_ = true;
  command_age_ = 0.0;
  return verdict;
}

void SimulatedDrive::step(double dt) {
  command_age_ += dt;
  arm_.step(dt);
  switch (arm_.mode()) {
    case planner::DriveMode::kTracking:
      mode_ = msg::ArmMode::ARM_RUNNING;
      break;
    case planner::DriveMode::kStopping:
      mode_ = msg::ArmMode::ARM_BRAKING;
      break;
    case planner::DriveMode::kIdle:
      if (mode_ != msg::ArmMode::ARM_STARTING) mode_ = msg::ArmMode::ARM_STOPPED;
      break;
  }
}

std::string SimulatedDrive::reason() const {
  if (mode_ == msg::ArmMode::ARM_RUNNING) return {};
  if (order_ != msg::Mode::MODE_RUN) return why_;
  if (!gate_.complaint().empty()) return gate_.complaint();
  if (!complaint_.empty()) return complaint_;
  if (!commanded_) return "no command came yet";
  if (command_age_ > command_timeout_) {
    char text[64];
    std::snprintf(text, sizeof text, "commands ceased: none for more than %.0f ms", command_timeout_ * 1e3);
    return text;
  }
  return "begins to follow commands";
}

}  // namespace hecaton::services
