#pragma once
/// Damper parameters of an arm whose cell file leaves them open.

#include <optional>

#include "planner/local/parameters.hpp"

namespace hecaton::planner {

/// What the defaults of a damper follow from.
struct DamperBasis {
  double reach = 1.0;            ///< of the tool from the first joint [m]
  double stop_time = 0.0;        ///< the longest stop of the arm [s]
  double control_period = 0.01;  ///< until the arm reacts to its own state [s]
  double latency = 0.02;         ///< until the arm reacts to an obstacle [s]
};

/// The parameters that the user gave.
struct GivenDamper {
  std::optional<double> influence_distance = {};
  std::optional<double> security_distance = {};
  std::optional<double> convergence_speed = {};
  std::optional<double> self_influence_distance = {};
  std::optional<double> self_security_distance = {};
};

/// Fills in what is not given. Distances grow with the reach. Braking can keep the damper, and the security distance
/// covers the latency, as far as the given values allow it (docs/explanation/0001-braking.md). Pure.
[[nodiscard]] DamperParameters default_damper(const DamperBasis& basis, const GivenDamper& given = {});

}  // namespace hecaton::planner
