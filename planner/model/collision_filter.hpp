#pragma once
/// Which pairs of an arm's own collision shapes are worth checking against each other.

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// All pairs of geometry indices (first < second) but those of one rigid body and of two bodies that one joint
/// connects: those touch by construction, or are kept apart by the joint's limits.
[[nodiscard]] std::vector<std::pair<int, int>> pairs_of_separate_bodies(const RobotModel& model);

/// Signed distance [m] of two shapes at two poses in a common frame; never above the true one by more than 1e-6 m.
using PairDistance = std::function<double(const world::Shape&, const Pose&, const world::Shape&, const Pose&)>;

struct FilterOptions {
  int samples = 500;  ///< random configurations a pair must touch in to count as always touching
  std::uint64_t random_seed = 1;
  double apart = 0.02;      ///< pairs are dropped when they are proven never to come nearer than this [m]
  int proof_budget = 2000;  ///< distance evaluations a pair; pairs whose proof needs more are kept
};

/// Removes from model.self_pairs those that touch in every sampled configuration (they overlap by construction) and
/// those that are proven to stay apart in all configurations within the limits. A pair that is merely not seen to touch
/// stays. Adds a note of what it removed.
void automatic_filter(RobotModel& model, const PairDistance& distance, const FilterOptions& options = {});

}  // namespace hecaton::planner
