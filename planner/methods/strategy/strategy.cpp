#include "planner/methods/strategy/strategy.hpp"

#include "planner/methods/strategy/plane.hpp"

namespace hecaton::planner {

static_assert(baseline::kPlaneJoints == kMaxJoints);

NullSpaceBasis null_space_basis(const JointVector& u1) {
  const int n = static_cast<int>(u1.size());
  double v[kMaxJoints][kMaxJoints];
  baseline::null_space(u1.data(), n, v);
  NullSpaceBasis basis(n - 1, n);
  for (int i = 0; i + 1 < n; ++i) {
    for (int j = 0; j < n; ++j) basis(i, j) = v[i][j];
  }
  return basis;
}

ReducedSubspace reduced_subspace(const JointVector& q_start, const JointVector& q_goal, const Strategy& strategy) {
  const JointVector way = q_goal - q_start;
  ReducedSubspace plane{q_start, way, way, way.norm()};
  plane.u1 /= plane.distance;
  baseline::strategy_direction(plane.u1.data(), static_cast<int>(way.size()), strategy.coefficients.data(),
                               strategy.direction, plane.u2.data());
  return plane;
}

void begin_strategy(const StrategyParameters& parameters, const JointVector& q, const JointVector& way,
                    StrategyMemory& memory) {
  const int avoiding = avoiding_joints(parameters, static_cast<int>(way.size()));
  if (!(way.head(avoiding).norm() > 0.0)) return;
  const JointVector start = q.head(avoiding);
  memory.plane = reduced_subspace(start, start + way.head(avoiding), parameters.strategy);
  memory.side = 1.0;
  memory.x = memory.y = 0.0;
  memory.under_way = true;
}

void take_step(double step, const IsFree& is_free, StrategyMemory& memory) {
  const ReducedSubspace& plane = memory.plane;
  const baseline::PlaneState state{{memory.x, memory.y}, memory.side};
  const baseline::PlaneFrame frame = baseline::plane_frame(state.at, plane.distance);
  if (!(frame.left > 0.0)) return;
  for (int k = 0; k < baseline::kNeighbours; ++k) {
    const baseline::PlanePoint next = baseline::neighbour(state, frame, plane.distance, step, k);
    if (!is_free(plane.at(next.x, next.y))) continue;
    memory.x = next.x;
    memory.y = next.y;
    return;
  }
  memory.side = -memory.side;
}

}  // namespace hecaton::planner
