#pragma once
/// Parameters of the reactive planner for any motion method, with the symbols of [Lahouar06].

#include <algorithm>
#include <limits>
#include <memory>
#include <optional>
#include <string>

namespace hecaton::planner {

class MotionMethod;

/// Boundary following with default parameters; planner/methods/registry.cpp. Thread-safe.
[[nodiscard]] std::shared_ptr<const MotionMethod> default_method();

/// The velocity damper: the allowed approach speed of a pair of bodies as a function of their distance. The paper's
/// line ξ (d − dₛ)/(dᵢ − dₛ) has the time constant S₀ = (dᵢ − dₛ)/ξ. For an arm that needs longer than S₀ to react and
/// stop, the curve is flatter beyond the speed ξ:
///   f(x) = x / S(x),   S(x) = clamp(x/ξ, S₀, response),   x = d − dₛ
/// Braking keeps this bound if stops take no longer than S(x) − dt (docs/explanation/0001-braking.md).
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

/// No posture brings the links of a ClosePair farther apart than its widest distance w [m]. With the dₛ of other links
/// the damper could ask for a retreat that no joint can make. dₛ of such a pair is at most this share of w.
inline constexpr double kSecurityShare = 0.25;
/// Starts and goals need at most this share of w between the two links, and the damper influences the arm only below.
inline constexpr double kRestShare = 0.5;

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
  /// `widest`: the largest distance of the two links in any posture [m]. The damper of a close pair is smaller, with
  /// the same slope, so that braking can keep it as well as the damper of any pair.
  [[nodiscard]] Damper against_self(double response, double widest = std::numeric_limits<double>::infinity()) const {
    const double scale = std::min(1.0, kSecurityShare * widest / self_security_distance);
    return {scale * self_security_distance, scale * (self_influence_distance - self_security_distance),
            scale * convergence_speed, response};
  }
};

/// Requests of the right of way, and yielding (planner/local/right_of_way.hpp).
struct YieldingParameters {
  /// The arm requests after it has been blocked for about this long [s]; 0: it neither requests nor yields.
  double yield_request_delay = 2.0;
  bool at_rest = true;  ///< the arm also yields at its goal, and without a goal
};

/// Rollouts of a blocked arm (planner/rollout).
struct RolloutParameters {
  int candidates = 8;             ///< manoeuvres that one question simulates; 0: no rollouts
  double horizon = 2.0;           ///< of the first question [s]
  double horizon_growth = 1.3;    ///< factor of the horizon with each further question, ≥ 1
  double longest_horizon = 10.0;  ///< limit of the horizon [s]
  double interval = 0.2;          ///< between an answer and the next question [s]
  int ticks_per_period = 400;     ///< simulated ticks of single arms in each control period, > 0
};

/// When an arm asks a global planner for a route around everything as it stands (planner/route).
struct ReplanningParameters {
  double stall_timeout = 1.0;  ///< time without progress to the goal [s]; 0: never
};

/// When an arm with the right of way proposes a coupled plan for itself and all arms that can come near it.
struct CoordinationParameters {
  double stall_timeout = 2.0;  ///< time without progress to the goal [s]; 0: never, and the arm joins no coupled plan
};

struct LocalParameters {
  std::shared_ptr<const MotionMethod> method = default_method();  ///< what velocity the arm wants; never null
  DamperParameters damper;
  YieldingParameters yielding;
  RolloutParameters rollout;
  ReplanningParameters replanning;
  CoordinationParameters coordination;
  double goal_tolerance = 2e-3;            ///< every joint within this of the goal counts as reached [rad | m]
  double acceleration_of_obstacles = 2.0;  ///< assumed bound for margins against aged states [m/s²]
  double state_age_limit = 0.25;           ///< an older state of an arm or obstacle stops this arm [s]

  /// Nothing if consistent; otherwise one sentence with key, value and rule. MotionMethod::validate checks the method.
  [[nodiscard]] std::optional<std::string> validate() const;
};

}  // namespace hecaton::planner
