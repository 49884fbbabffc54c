#include "planner/rollout/rollout_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planner/local/goal_objective.hpp"

namespace hecaton::planner {
namespace {

/// Step of the play [s]: coarser than a control period, since only the choice depends on it, never the motion.
constexpr double kStep = 0.025;
/// Way that is left at the horizon counts this much more than the time it would take straight: something is in its way.
constexpr double kDoubt = 2.0;
/// Going on is kept unless something else is expected to be this much faster [s]: plays are predictions.
constexpr double kWorthwhile = 0.2;
/// Detours: each joint of the way-point differs from the present one with this probability, by a normal deviate.
constexpr double kMovedShare = 0.5;
constexpr double kDetourReach = 0.7;     // [rad | m]
constexpr double kDetourPatience = 2.0;  // [s]

double straight_time(const JointLimits& limits, const PlayedArm& arm) {
  return joint_difference(limits, arm.q, arm.q_goal).cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff();
}

}  // namespace

RolloutSearch::RolloutSearch(const std::vector<Arm>& arms, std::vector<LocalParameters> parameters, int self)
    : cell_(arms, std::move(parameters), kStep), self_(self) {
  question_.candidates = 0;
}

void RolloutSearch::set_obstacles(std::span<const world::Obstacle> obstacles) {
  cell_.set_obstacles(obstacles);
  candidate_ = question_.candidates + 1;
}

void RolloutSearch::begin(RolloutQuestion question) {
  question_ = std::move(question);
  random_ = Random(question_.seed);
  candidate_ = 0;
  best_ = {};
  best_.cost = std::numeric_limits<double>::infinity();
  start_candidate();
}

// Half of the candidates follow the boundary in a fresh subspace, half make a detour; one goes straight.
Manoeuvre RolloutSearch::draw(int candidate) {
  Manoeuvre manoeuvre;
  if (candidate == 0) return manoeuvre;
  manoeuvre.seed = random_.next();
  if (candidate == 1) {
    manoeuvre.kind = ManoeuvreKind::kLetGo;
  } else if (candidate % 2 == 0) {
    manoeuvre.kind = ManoeuvreKind::kSubspace;
  } else {
    manoeuvre.kind = ManoeuvreKind::kDetour;
    const JointLimits& limits = cell_.limits(self_);
    manoeuvre.q = question_.arms[self_].q;
    for (auto& value : manoeuvre.q) {
      if (random_.uniform() < kMovedShare) value += kDetourReach * random_.normal();
    }
    manoeuvre.q = manoeuvre.q.cwiseMax(limits.lower).cwiseMin(limits.upper);
    manoeuvre.patience = kDetourPatience;
  }
  return manoeuvre;
}

void RolloutSearch::start_candidate() {
  manoeuvre_ = draw(candidate_);
  cell_.begin(question_.arms, question_.obstacles);
  hecaton::planner::begin(manoeuvre_, cell_.arm(self_).memory);
}

bool RolloutSearch::finished() const {
  if (cell_.time() >= question_.horizon) return true;
  for (int i = 0; i < cell_.arms(); ++i) {
    if (cell_.arm(i).has_goal && cell_.arm(i).plans && cell_.reached(i) < 0.0) return false;
  }
  return true;
}

double RolloutSearch::cost() const {
  double sum = 0.0;
  for (int i = 0; i < cell_.arms(); ++i) {
    const PlayedArm& arm = cell_.arm(i);
    if (!arm.has_goal || !arm.plans) continue;
    sum += cell_.reached(i) >= 0.0 ? cell_.reached(i) : cell_.time() + kDoubt * straight_time(cell_.limits(i), arm);
  }
  return sum;
}

std::optional<RolloutAnswer> RolloutSearch::advance(int ticks) {
  while (busy() && ticks > 0) {
    while (!finished() && ticks > 0) {
      cell_.step();
      ticks -= cell_.arms();
    }
    if (!finished()) return std::nullopt;
    const double cost = this->cost();
    if (candidate_ == 0) best_.cost_of_going_on = cost;
    if (cost < (candidate_ == 0 ? best_.cost : std::min(best_.cost, best_.cost_of_going_on - kWorthwhile))) {
      best_.manoeuvre = manoeuvre_;
      best_.cost = cost;
      best_.arrives = cell_.reached(self_) >= 0.0;
    }
    if (++candidate_ > question_.candidates) return best_;
    start_candidate();
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
