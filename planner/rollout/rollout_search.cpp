#include "planner/rollout/rollout_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planner/local/goal_objective.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Time step [s]. Larger than a control period, because only the selection depends on it, not the motion.
constexpr double kStep = 0.025;
/// Time step of a lookahead [s]: the success of a retreat may depend on hundredths of a second.
constexpr double kLookaheadStep = 0.0125;
/// Factor of the straight time for the distance that is left at the horizon: an obstacle probably blocks it.
constexpr double kDoubt = 2.0;
/// A manoeuvre must be this much faster than continuing [s], because rollouts are only predictions.
constexpr double kWorthwhile = 0.2;
/// Detours: each joint of the way-point differs from the present one with this probability, by a normal deviate.
constexpr double kMovedShare = 0.5;
constexpr double kDetourReach = 0.7;  // [rad | m]
constexpr double kDetourTime = 2.0;   // [s]
/// Escapes are nearer and farther, and last shorter and longer.
constexpr double kLongestEscape = 1.4;  // [rad | m]
constexpr double kShortestStay = 0.4;   // [s]
constexpr double kLongestStay = 1.2;    // [s]
/// Tolerated violation of dₛ as a share of dₛ: the time step is large, and dampers allow distances of exactly dₛ.
constexpr double kTolerated = 0.3;
/// The same for moving obstacles. Dampers never allow less than dₛ here, so that a violation means a failed retreat.
constexpr double kToleratedOfMoving = 0.05;
/// Cost of a violation of one dₛ, which is a contact [s]: more than any detour.
constexpr double kCostOfMargin = 50.0;

double straight_time(const JointLimits& limits, const RolloutArm& arm) {
  return joint_difference(limits, arm.q, arm.q_goal).cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff() /
         std::max(arm.speed, kSlowestShare);
}

template <typename T>
std::vector<T> picked(const std::vector<T>& all, const std::vector<int>& indices) {
  std::vector<T> some;
  for (const int i : indices) some.push_back(all[i]);
  return some;
}

/// Removes the shapes of objects that arms outside the simulation carry.
std::vector<world::Obstacle> near_obstacles(std::span<const world::Obstacle> obstacles,
                                            const std::vector<Arm>& played) {
  std::vector<world::Obstacle> near(obstacles.begin(), obstacles.end());
  for (world::Obstacle& obstacle : near) {
    if (!obstacle.attachment) continue;
    const auto carries = [&](const Arm& arm) { return arm.name == obstacle.attachment->arm; };
    if (std::any_of(played.begin(), played.end(), carries)) continue;
    obstacle.attachment.reset();
    obstacle.shapes.clear();
  }
  return near;
}

}  // namespace

RolloutSearch::RolloutSearch(std::vector<Arm> arms, std::vector<LocalParameters> parameters, int self)
    : arms_(std::move(arms)), parameters_(std::move(parameters)), self_(self), cell_({}, {}, kStep) {
  question_.candidates = 0;
  set_obstacles({});
}

void RolloutSearch::set_obstacles(std::span<const world::Obstacle> obstacles) {
  CellGeometry whole(arms_, self_);
  whole.set_obstacles(obstacles);
  double influence = 0.0;
  for (const LocalParameters& parameters : parameters_) {
    influence = std::max(influence, parameters.damper.influence_distance);
  }
  simulated_arms_ = whole.neighbourhood(influence);
  own_ = static_cast<int>(std::lower_bound(simulated_arms_.begin(), simulated_arms_.end(), self_) -
                          simulated_arms_.begin());
  const std::vector<Arm> arms = picked(arms_, simulated_arms_);
  cell_ = RolloutSimulation(arms, picked(parameters_, simulated_arms_), kStep);
  cell_.set_obstacles(near_obstacles(obstacles, arms));
  candidate_ = question_.candidates + 1;
}

void RolloutSearch::begin(RolloutQuestion question) {
  question_ = std::move(question);
  question_.arms = picked(question_.arms, simulated_arms_);
  random_ = Random(question_.seed);
  candidate_ = 0;
  best_ = {};
  best_.cost = std::numeric_limits<double>::infinity();
  start_candidate();
}

JointVector RolloutSearch::somewhere(double reach) {
  const JointLimits& limits = cell_.limits(own_);
  JointVector q = question_.arms[own_].q;
  for (auto& value : q) {
    if (random_.uniform() < kMovedShare) value += reach * random_.normal();
  }
  return q.cwiseMax(limits.lower).cwiseMin(limits.upper);
}

// The first candidate moves straight; the next ones follow the boundary in a new subspace or make a detour, in turns.
Manoeuvre RolloutSearch::draw(int candidate) {
  Manoeuvre manoeuvre;
  if (candidate == 0) return manoeuvre;
  if (question_.lookahead) return draw_escape(candidate);
  manoeuvre.seed = random_.next();
  if (candidate == 1) {
    manoeuvre.kind = ManoeuvreKind::kAbandon;
  } else if (candidate % 2 == 0) {
    manoeuvre.kind = ManoeuvreKind::kSubspace;
  } else {
    manoeuvre.kind = ManoeuvreKind::kDetour;
    manoeuvre.q = somewhere(kDetourReach);
    manoeuvre.time_limit = kDetourTime;
  }
  return manoeuvre;
}

// The first candidate moves straight, two stop and wait, and the rest evade to random positions.
Manoeuvre RolloutSearch::draw_escape(int candidate) {
  Manoeuvre manoeuvre;
  manoeuvre.seed = random_.next();
  if (candidate == 1) {
    manoeuvre.kind = ManoeuvreKind::kAbandon;
    return manoeuvre;
  }
  const RolloutArm& own = question_.arms[own_];
  manoeuvre.kind = ManoeuvreKind::kEvade;
  if (candidate <= 3) {
    manoeuvre.q = rest_position(cell_.limits(own_), own.q, own.qd);
    manoeuvre.time_limit = candidate == 2 ? kShortestStay : kLongestStay;
  } else {
    manoeuvre.q = somewhere(random_.uniform(0.0, kLongestEscape));
    manoeuvre.time_limit = random_.uniform(kShortestStay, kLongestStay);
  }
  return manoeuvre;
}

void RolloutSearch::start_candidate() {
  manoeuvre_ = draw(candidate_);
  cell_.begin(question_.arms, question_.obstacles, question_.accelerations,
              question_.lookahead ? kLookaheadStep : kStep);
  hecaton::planner::begin(manoeuvre_, cell_.arm(own_).memory);
  path_.assign(1, cell_.arm(own_).q);
}

void RolloutSearch::note_path() {
  const double due = kRolloutPathStep * static_cast<double>(path_.size()) - 1e-9;  // steps add up with rounding
  if (path_.size() < kMostRolloutPoints && cell_.time() >= due) path_.push_back(cell_.arm(own_).q);
}

/// Violation of the tolerated margin by arm i, in units of dₛ.
double RolloutSearch::danger(int arm) const {
  const double security = parameters_[simulated_arms_[arm]].damper.security_distance;
  const double of_any = -cell_.clearance_margin(arm) / security - kTolerated;
  const double of_moving = -cell_.clearance_margin_of_moving(arm) / security - kToleratedOfMoving;
  return std::max({0.0, of_any, of_moving});
}

double RolloutSearch::dangers() const {
  double sum = 0.0;
  for (int i = 0; i < cell_.arms(); ++i) sum += danger(i);
  return sum;
}

bool RolloutSearch::finished() const {
  if (cell_.time() >= question_.horizon) return true;
  if (candidate_ > 0 && kCostOfMargin * dangers() >= best_.cost) return true;  // cannot become the best
  if (question_.lookahead) return false;
  for (int i = 0; i < cell_.arms(); ++i) {
    if (cell_.arm(i).has_goal && cell_.arm(i).plans && cell_.reached(i) < 0.0) return false;
  }
  return true;
}

double RolloutSearch::cost() const {
  double sum = kCostOfMargin * dangers();
  for (int i = 0; i < cell_.arms(); ++i) {
    const RolloutArm& arm = cell_.arm(i);
    if (!arm.has_goal || !arm.plans) continue;
    sum += cell_.reached(i) >= 0.0 ? cell_.reached(i) : cell_.time() + kDoubt * straight_time(cell_.limits(i), arm);
  }
  return sum;
}

std::optional<RolloutAnswer> RolloutSearch::advance(int ticks) {
  while (busy() && ticks > 0) {
    while (!finished() && ticks > 0) {
      cell_.step();
      note_path();
      ticks -= cell_.arms();
      ticks_ += static_cast<std::uint64_t>(cell_.arms());
    }
    if (!finished()) return std::nullopt;
    const double cost = this->cost();
    if (candidate_ == 0) best_.cost_of_continuing = cost;
    if (cost < (candidate_ == 0 ? best_.cost : std::min(best_.cost, best_.cost_of_continuing - kWorthwhile))) {
      best_.manoeuvre = manoeuvre_;
      best_.cost = cost;
      best_.arrives = cell_.reached(own_) >= 0.0;
      best_.path = path_;
    }
    // A danger of another arm counts, too: the own arm may block its escape.
    const bool well = question_.lookahead && candidate_ == 0 && dangers() <= 0.0;
    if (well) candidate_ = question_.candidates;
    if (++candidate_ > question_.candidates) return best_;
    start_candidate();
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
