#pragma once
/// Parameters of the reactive planner, with the symbols of [Lahouar06] and the values that worked.

#include <algorithm>
#include <cmath>
#include <string>

#include "planner/strategy/strategy.hpp"

namespace hecaton::planner {

/// What decides a tick.
enum class Method {
  kLocal,              ///< constraints alone: the baseline of [Lahouar06] section 2
  kBoundaryFollowing,  ///< + boundary following, section 3, in ever fresh subspaces; right of way; rollouts
  kSingleSubspace,     ///< boundary following as the paper has it: in one subspace as long as it takes, nothing else
  kSensedCspace,       ///< a way through what the own sensors leave free in C-space: [Li96], planner/cspace
  kKnownCspace,        ///< the same for an arm that is told all obstacles, which must stand still: the measure of it
  kPotentialField,     ///< down the gradient of artificial potentials: [Cardenas10], planner/potential
  kStrategy,           ///< constraints, and a way round them in the plane that a strategy chooses: [Mediavilla02]
  kStrategyStep,       ///< the strategy's steps as published: to free neighbours in that plane
};

/// How fast a pair may approach. The paper's line, ξ (d − dₛ)/(dᵢ − dₛ), is one of time constant S₀ = (dᵢ − dₛ)/ξ; an
/// arm that needs longer than S₀ to react and stop follows it only up to ξ, and a flatter one farther out:
///   f(x) = x / S(x),   S(x) = clamp(x/ξ, S₀, response),   x = d − dₛ
/// Braking can keep it where stops take no longer than S(x) − dt (docs/design/0001-braking.md).
struct Damper {
  double security_distance;  ///< dₛ [m]
  double width;              ///< dᵢ − dₛ [m]
  double convergence_speed;  ///< ξ [m/s]
  double response;           ///< one period and the longest stop [s]

  [[nodiscard]] double time_constant(double distance) const {
    return std::clamp((distance - security_distance) / convergence_speed, width / convergence_speed, longest());
  }
  /// Allowed approach speed [m/s]: zero at dₛ, negative (retreat) below.
  [[nodiscard]] double speed(double distance) const { return (distance - security_distance) / time_constant(distance); }
  /// The steepest slope [1/s], next to dₛ.
  [[nodiscard]] double slope() const { return convergence_speed / width; }
  /// The largest time constant [s], far away.
  [[nodiscard]] double longest() const { return std::max(width / convergence_speed, response); }
};

struct DamperParameters {
  double influence_distance = 0.12;       ///< dᵢ [m], > security_distance
  double security_distance = 0.02;        ///< dₛ [m], > 0
  double convergence_speed = 1.0;         ///< ξ [m/s], > 0; ξ/2 between two planned arms (eq. 8)
  double self_influence_distance = 0.11;  ///< dᵢ between links of the same arm [m]
  double self_security_distance = 0.01;   ///< dₛ between links of the same arm [m]

  /// The damper [m/s] against obstacles and arms, and between links of the same arm.
  [[nodiscard]] Damper against_others(double response) const {
    return {security_distance, influence_distance - security_distance, convergence_speed, response};
  }
  [[nodiscard]] Damper against_self(double response) const {
    return {self_security_distance, self_influence_distance - self_security_distance, convergence_speed, response};
  }
};

struct FollowerParameters {
  double deadlock_fraction = 0.30;  ///< follow when ‖Δq‖ < this · min(‖q_goal − q‖, Δq_max)  (section 4)
  double exit_fraction = 0.80;      ///< back to the local planner when V(q) < this · d_lock     (section 4)
  double redraw_after = 1.0;        ///< [s] in the first subspace before a fresh U₂ is drawn; 0: never (the paper)
  double redraw_growth = 1.25;      ///< each further subspace of a goal gets this many times longer, ≥ 1
  int most_switches = 6;            ///< changes of the followed constraint before a fresh U₂ is drawn
  double redraw_longest = 8.0;      ///< but no longer than this [s], ≥ redraw_after

  /// How long the k-th subspace of a goal may be followed, k = 1, 2, … [s].
  [[nodiscard]] double patience(int k) const {
    return std::min(redraw_longest, redraw_after * std::pow(redraw_growth, k - 1));
  }
};

/// When an arm asks the others to make room, and makes room itself (planner/local/right_of_way.hpp).
struct YieldingParameters {
  double patience = 2.0;  ///< held back for about this long, an arm asks [s]; 0: it neither asks nor makes room
  bool at_rest = true;    ///< it makes room also when it rests at its goal, or has none
};

/// How an arm that is held back looks ahead (planner/rollout).
struct RolloutParameters {
  int candidates = 8;             ///< manoeuvres played through at a time; 0: none, boundary following alone decides
  double horizon = 2.0;           ///< of the first look ahead [s]
  double horizon_growth = 1.3;    ///< each further one looks this many times farther, ≥ 1
  double longest_horizon = 10.0;  ///< but no farther than this [s]
  double interval = 0.2;          ///< between an answer and the next question [s]
  int ticks_per_period = 400;     ///< of single arms, that may be spent on it in a control period, > 0
};

/// When an arm asks a global planner for a way around everything as it stands (planner/route).
struct RouteParameters {
  double after = 1.0;           ///< when it has not come nearer to its goal for so long [s]; 0: never
  double together_after = 2.0;  ///< the same with the right of way: it proposes a plan for all that can come near [s]
};

/// How long an arm remembers what it saw (docs/design/0012-sensed-cspace.md says when it then arrives).
enum class Remember {
  kNever,        ///< it plans with what it sees now, as published: "We do not accumulate historical FO_i"
  kUntilNearer,  ///< from where something comes in its way until the goal is in sight and nearer than there
  kAlways,
};

/// What an arm knows of its C-space (planner/cspace).
struct SensedParameters {
  int cells = 180;       ///< of a full turn of each joint, 36 to 1440, a multiple of 4
  double margin = 0.03;  ///< kept from what was seen, for what is between two beams [m], > 0
  Remember remember = Remember::kAlways;
};

/// What the goal attracts.
enum class Attraction {
  kControlPoints,  ///< each control point in W, to where it is at the goal: [Cardenas10] eq. 5
  kJoints,         ///< the arm as a point in Q: [Cardenas10] eq. 2 as it stands
};

/// Artificial potentials [Cardenas10, eq. 2 and 3] with ζ = 1: only η/ζ shapes the field.
struct PotentialParameters {
  Attraction attraction = Attraction::kControlPoints;
  double goal_distance = 0.3;       ///< d*_goal: farther away the attraction grows no more [m | rad], > 0
  double repulsion = 1e-4;          ///< η [m⁴], > 0
  double influence_distance = 0.2;  ///< Q*: obstacles farther away do not repel [m], > 0
  double spacing = 0.15;            ///< control points on a link are no farther apart than this [m], > 0
};

struct LocalParameters {
  Method method = Method::kBoundaryFollowing;
  DamperParameters damper;
  FollowerParameters follower;
  YieldingParameters yielding;
  RolloutParameters rollout;
  RouteParameters route;
  SensedParameters sensed;
  PotentialParameters potential;
  StrategyParameters strategy;
  double goal_tolerance = 2e-3;            ///< every joint within this of the goal counts as reached [rad | m]
  double acceleration_of_obstacles = 2.0;  ///< assumed bound for margins against aged states [m/s²]
  double state_age_limit = 0.25;           ///< older news of an arm or obstacle stops this arm [s]

  /// The way is searched in C-space.
  [[nodiscard]] bool by_cspace() const { return method == Method::kSensedCspace || method == Method::kKnownCspace; }

  /// Empty when consistent; otherwise one sentence: key, value, what is allowed.
  [[nodiscard]] std::string validate() const;
};

}  // namespace hecaton::planner
