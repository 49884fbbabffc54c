#include "tests/bench/journeys.hpp"

#include <array>
#include <cmath>

namespace hecaton::bench {
namespace {

using namespace planner;

constexpr double kPeriod = 0.010;  // [s]
constexpr int kTicksAJourney = 250;
/// Least distance from other bodies at a start [m].
constexpr double kFree = 0.03;

Instant draw_start(PairsCell& cell, ExactDistance& distance) {
  std::array<Clearance, 1> one;
  while (true) {
    Instant instant = cell.draw();
    const CellPoses poses{instant.kinematics.data(), instant.kinematics, instant.obstacles};
    if (distance.clearances(poses, {kFree, 0.0, {}}, one) == 0) return instant;
  }
}

}  // namespace

Journeys::Journeys(LinkShapes shapes)
    : cell_(20060521, shapes), distance_(geometry()), scratch_(geometry()), arms_(geometry().arms().size()) {
  set_off();
}

void Journeys::set_off() {
  start_ = instant_ = draw_start(cell_, distance_);
  memory_ = {LocalMemory(static_cast<std::uint64_t>(++journey_))};
  input_ = {};
  input_.dt = kPeriod;
  input_.q = start_.q[0];
  input_.qd = JointVector::Zero(input_.q.size());
  input_.has_goal = true;
  input_.q_goal = cell_.draw().q[0];
  input_.arms = arms_;
  input_.obstacles = instant_.obstacles;
  ticks_ = 0;
  look_around();
}

void Journeys::advance(const TickResult& result) {
  if (++ticks_ == kTicksAJourney) {
    set_off();
    return;
  }
  input_.q = result.q;
  input_.qd = result.qd;
  if (result.status == TickStatus::kReached) input_.q_goal = cell_.draw().q[0];
  look_around();
}

void Journeys::look_around() {
  constexpr double kAmplitude = 0.4;  // [rad]
  constexpr double kRate = 1.5;       // [rad/s]
  for (int i = 0; i < static_cast<int>(arms_.size()); ++i) {
    if (i > 0) {
      const double phase = kRate * ticks_ * kPeriod + i;
      arms_[i].q = start_.q[i].array() + kAmplitude * std::sin(phase);
      arms_[i].qd = JointVector::Constant(start_.q[i].size(), kAmplitude * kRate * std::cos(phase));
      arms_[i].known = arms_[i].plans = true;
    }
    instant_.q[i] = i == 0 ? input_.q : arms_[i].q;
    const Arm& arm = geometry().arms()[i];
    forward_kinematics(*arm.model, arm.X_WB, instant_.q[i], instant_.kinematics[i]);
  }
}

}  // namespace hecaton::bench
