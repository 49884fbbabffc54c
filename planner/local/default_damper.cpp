#include "planner/local/default_damper.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner {
namespace {

/// Arms outside this range get the distances of its ends [m].
constexpr double kShortestReach = 0.3;
constexpr double kLongestReach = 2.0;
/// Shares of the reach.
constexpr double kSecurity = 0.02;
constexpr double kSelfSecurity = 0.01;
constexpr double kWidth = 0.10;
/// The least convergence speed per reach [1/s]. An arm that brakes slowly gets a wider damper, not a slower approach.
constexpr double kLeastSpeed = 0.25;
/// Of a given influence distance, at most this share is security distance.
constexpr double kMostSecurity = 0.25;

constexpr double kResolution = 1e-3;  // of the results [m | m/s]

double rounded_down(double value) {
  return std::max(kResolution, kResolution * std::floor(value / kResolution + 1e-6));
}
double rounded_up(double value) {
  return kResolution * std::ceil(value / kResolution - 1e-6);
}

double security(const std::optional<double>& given, const std::optional<double>& influence, double usual) {
  if (given) return *given;
  return influence ? std::min(usual, kMostSecurity * *influence) : usual;
}

double width(const std::optional<double>& influence, double security_distance, double usual) {
  return influence ? std::max(0.0, *influence - security_distance) : usual;
}

}  // namespace

DamperParameters default_damper(const DamperBasis& basis, const GivenDamper& given) {
  const double reach = std::clamp(basis.reach, kShortestReach, kLongestReach);
  const double response = basis.stop_time + basis.control_period;
  DamperParameters damper;
  damper.security_distance = security(given.security_distance, given.influence_distance, rounded_up(kSecurity * reach));
  damper.self_security_distance =
      security(given.self_security_distance, given.self_influence_distance, rounded_up(kSelfSecurity * reach));
  const double others = width(given.influence_distance, damper.security_distance, kWidth * reach);
  const double self = width(given.self_influence_distance, damper.self_security_distance, kWidth * reach);
  if (given.convergence_speed) {
    damper.convergence_speed = *given.convergence_speed;
  } else {
    // Braking keeps the damper if ξ ≤ (dᵢ − dₛ)/(T + dt), and dₛ covers the latency L if ξ ≤ dₛ/L.
    const bool may_widen = !given.influence_distance && !given.self_influence_distance;
    const double kept = std::min(others, self) / response;
    const double speed = may_widen ? std::max(kept, kLeastSpeed * reach) : kept;
    damper.convergence_speed = rounded_down(std::min(speed, damper.security_distance / basis.latency));
  }
  const double braking = damper.convergence_speed * response;
  damper.influence_distance =
      given.influence_distance.value_or(damper.security_distance + rounded_up(std::max(kWidth * reach, braking)));
  damper.self_influence_distance = given.self_influence_distance.value_or(
      damper.self_security_distance + rounded_up(std::max(kWidth * reach, braking)));
  return damper;
}

}  // namespace hecaton::planner
