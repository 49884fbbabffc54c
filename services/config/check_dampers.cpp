#include <algorithm>

#include "planner/trajectory/stop_profile.hpp"
#include "services/config/findings.hpp"
#include "services/config/text.hpp"
#include "services/config/top_speed.hpp"

namespace hecaton::config {
namespace {

// Both rules are of first order; rounded decimals in a cell file are no reason to warn.
constexpr double kTolerance = 0.02;

// An obstacle's motion is known a world step late and answered in the next tick. Meanwhile the approach goes on, at
// most with the speed that the dampers leave it: dₛ must be more than that way.
void check_latency(const planner::Cell& cell, int arm, Findings& findings) {
  const planner::PlannedArm& planned = cell.arms[arm];
  const planner::DamperParameters& damper = planned.parameters.damper;
  const double latency = cell.timing.world_period + cell.timing.control_period;
  const double speed = std::min(damper.convergence_speed, top_tool_speed(planned.arm));
  const double needed = speed * latency;
  if (damper.security_distance >= needed * (1.0 - kTolerance)) return;
  findings.push_back({Severity::kWarning,
                      arm_key(arm) + ".damper.security_distance = " + number_text(damper.security_distance) +
                          " should be at least " + number_text(needed) + " m: an approach at " + number_text(speed) +
                          " m/s goes on for " + number_text(latency * 1e3) + " ms before the arm answers"});
}

// docs/design/0001-braking.md: braking can keep a damper's line only when k = ξ/(dᵢ − dₛ) ≤ 1/(T + dt).
void check_slope(const planner::Cell& cell, int arm, const char* kind, double security, double influence,
                 Findings& findings) {
  const planner::PlannedArm& planned = cell.arms[arm];
  const double speed = planned.parameters.damper.convergence_speed;
  const double response = planner::longest_stop_time(planned.arm.limits) + cell.timing.control_period;
  const double braking_distance = speed * response;
  if (influence - security >= braking_distance * (1.0 - kTolerance)) return;
  findings.push_back({Severity::kWarning,
                      arm_key(arm) + ".damper." + kind + "influence_distance = " + number_text(influence) +
                          " should be at least " + number_text(security + braking_distance) +
                          " m: braking from convergence_speed = " + number_text(speed) + " m/s, with stops that take " +
                          number_text(response * 1e3) + " ms, needs " + number_text(braking_distance) + " m before " +
                          kind + "security_distance = " + number_text(security)});
}

}  // namespace

void check_dampers(const planner::Cell& cell, Findings& findings) {
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const planner::DamperParameters& damper = cell.arms[arm].parameters.damper;
    check_latency(cell, arm, findings);
    check_slope(cell, arm, "", damper.security_distance, damper.influence_distance, findings);
    check_slope(cell, arm, "self_", damper.self_security_distance, damper.self_influence_distance, findings);
  }
}

}  // namespace hecaton::config
