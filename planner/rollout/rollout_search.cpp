#include "planner/rollout/rollout_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "planner/local/goal_objective.hpp"
#include "planner/trajectory/stop_profile.hpp"

namespace hecaton::planner {
namespace {

/// Step of the play [s]: coarser than a control period, since only the choice depends on it, never the motion.
constexpr double kStep = 0.025;
/// Of a look at what comes: whether a retreat succeeds may hang on a few hundredths of a second.
constexpr double kLookaheadStep = 0.0125;
/// Way that is left at the horizon counts this much more than the time it would take straight: something is in its way.
constexpr double kDoubt = 2.0;
/// Going on is kept unless something else is expected to be this much faster [s]: plays are predictions.
constexpr double kWorthwhile = 0.2;
/// Detours: each joint of the way-point differs from the present one with this probability, by a normal deviate.
constexpr double kMovedShare = 0.5;
constexpr double kDetourReach = 0.7;     // [rad | m]
constexpr double kDetourPatience = 2.0;  // [s]
/// Escapes are nearer and farther, and last shorter and longer.
constexpr double kLongestEscape = 1.4;  // [rad | m]
constexpr double kShortestStay = 0.4;   // [s]
constexpr double kLongestStay = 1.2;    // [s]
/// Whoever comes nearer than dₛ by this share of it is in danger: plays are coarse, and dampers let dₛ be touched.
constexpr double kTolerated = 0.3;
/// From what moves no dampers let an arm get there: who does has lost the flight, however little the play says.
constexpr double kToleratedOfMoving = 0.05;
/// What it is worth not to come nearer by another dₛ, which is a contact [s]: more than any detour.
constexpr double kCostOfMargin = 50.0;

double straight_time(const JointLimits& limits, const RolloutArm& arm) {
  return joint_difference(limits, arm.q, arm.q_goal).cwiseAbs().cwiseQuotient(limits.velocity).maxCoeff();
}

template <typename T>
std::vector<T> picked(const std::vector<T>& all, const std::vector<int>& indices) {
  std::vector<T> some;
  for (const int i : indices) some.push_back(all[i]);
  return some;
}

/// What an arm carries that is not played is nowhere: as far away as that arm.
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

// Half of the candidates follow the boundary in a fresh subspace, half make a detour; one goes straight.
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
    manoeuvre.patience = kDetourPatience;
  }
  return manoeuvre;
}

// One goes straight, two stop and let pass what comes, the others get out of the way.
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
    manoeuvre.patience = candidate == 2 ? kShortestStay : kLongestStay;
  } else {
    manoeuvre.q = somewhere(random_.uniform(0.0, kLongestEscape));
    manoeuvre.patience = random_.uniform(kShortestStay, kLongestStay);
  }
  return manoeuvre;
}

void RolloutSearch::start_candidate() {
  manoeuvre_ = draw(candidate_);
  cell_.begin(question_.arms, question_.obstacles, question_.accelerations,
              question_.lookahead ? kLookaheadStep : kStep);
  hecaton::planner::begin(manoeuvre_, cell_.arm(own_).memory);
}

/// How far arm i came nearer than it may, in units of dₛ.
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
  if (candidate_ > 0 && kCostOfMargin * dangers() >= best_.cost) return true;  // it cannot win any more
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
    }
    // Also when it is another arm that is run down: whose way out this one may be in.
    const bool well = question_.lookahead && candidate_ == 0 && dangers() <= 0.0;
    if (well) candidate_ = question_.candidates;
    if (++candidate_ > question_.candidates) return best_;
    start_candidate();
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
