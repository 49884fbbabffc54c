#include "planner/local/parameters.hpp"

#include <cmath>
#include <sstream>

namespace hecaton::planner {
namespace {

std::string sentence(const char* key, double value, const std::string& rule) {
  std::ostringstream out;
  out << key << " = " << value << " must be " << rule;
  return out.str();
}

std::string below(const char* name, double value) {
  std::ostringstream out;
  out << "below " << name << " = " << value;
  return out.str();
}

std::string no_shorter(const char* name, double seconds) {
  std::ostringstream out;
  out << "a time in seconds, no shorter than " << name << " = " << seconds;
  return out.str();
}

bool positive(double value) {
  return std::isfinite(value) && value > 0.0;
}

}  // namespace

std::optional<std::string> LocalParameters::validate() const {
  const struct {
    const char* key;
    double value;
  } positives[] = {{"damper.influence_distance", damper.influence_distance},
                   {"damper.security_distance", damper.security_distance},
                   {"damper.convergence_speed", damper.convergence_speed},
                   {"damper.self_influence_distance", damper.self_influence_distance},
                   {"damper.self_security_distance", damper.self_security_distance},
                   {"goal_tolerance", goal_tolerance},
                   {"acceleration_of_obstacles", acceleration_of_obstacles},
                   {"state_age_limit", state_age_limit}};
  for (const auto& entry : positives) {
    if (!positive(entry.value)) return sentence(entry.key, entry.value, "a finite number above 0");
  }
  if (damper.security_distance >= damper.influence_distance) {
    return sentence("damper.security_distance", damper.security_distance,
                    below("influence_distance", damper.influence_distance));
  }
  if (damper.self_security_distance >= damper.self_influence_distance) {
    return sentence("damper.self_security_distance", damper.self_security_distance,
                    below("self_influence_distance", damper.self_influence_distance));
  }
  if (!std::isfinite(yielding.yield_request_delay) || yielding.yield_request_delay < 0.0) {
    return sentence("yielding.yield_request_delay", yielding.yield_request_delay, "0 (never) or a time in seconds");
  }
  if (!positive(rollout.horizon)) return sentence("rollout.horizon", rollout.horizon, "a time in seconds above 0");
  if (!std::isfinite(rollout.horizon_growth) || rollout.horizon_growth < 1.0) {
    return sentence("rollout.horizon_growth", rollout.horizon_growth, "1 or more");
  }
  if (!std::isfinite(rollout.longest_horizon) || rollout.longest_horizon < rollout.horizon) {
    return sentence("rollout.longest_horizon", rollout.longest_horizon, no_shorter("horizon", rollout.horizon));
  }
  if (!positive(rollout.interval)) return sentence("rollout.interval", rollout.interval, "a time in seconds above 0");
  if (rollout.candidates < 0) return sentence("rollout.candidates", rollout.candidates, "0 (none) or more");
  if (rollout.ticks_per_period < 1) {
    return sentence("rollout.ticks_per_period", rollout.ticks_per_period, "1 or more");
  }
  if (!std::isfinite(replanning.stall_timeout) || replanning.stall_timeout < 0.0) {
    return sentence("replanning.stall_timeout", replanning.stall_timeout, "0 (never) or a time in seconds");
  }
  if (!std::isfinite(coordination.stall_timeout) || coordination.stall_timeout < 0.0) {
    return sentence("coordination.stall_timeout", coordination.stall_timeout, "0 (never) or a time in seconds");
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
