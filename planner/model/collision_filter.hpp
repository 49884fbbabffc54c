#pragma once
/// Which pairs of an arm's own collision shapes are worth checking against each other.

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "planner/model/robot_model.hpp"

namespace hecaton::planner {

/// All pairs of geometry indices (first < second) except pairs of one rigid body and of two bodies that one joint
/// connects. Those touch by construction, or the joint's limits keep them apart.
[[nodiscard]] std::vector<std::pair<int, int>> pairs_of_separate_bodies(const RobotModel& model);

/// Signed distance [m] of two shapes at two poses in a common frame. It exceeds the true distance by at most 1e-6 m.
using PairDistance = std::function<double(const world::Shape&, const Pose&, const world::Shape&, const Pose&)>;

struct FilterOptions {
  int samples = 500;  ///< a pair that touches in all these random configurations counts as always touching
  std::uint64_t random_seed = 1;
  double apart = 0.02;      ///< the filter drops pairs that provably never come nearer than this [m]
  int proof_budget = 2000;  ///< distance evaluations per pair; the filter keeps pairs whose proof needs more
};

/// Removes two kinds of pairs from model.self_pairs. Pairs that touch in every sampled configuration overlap by
/// construction. Other pairs provably stay apart in all configurations within the limits. A pair without proof stays,
/// even if no sample touches. Adds a note with the removed pairs. Deterministic for a random_seed.
void automatic_filter(RobotModel& model, const PairDistance& distance, const FilterOptions& options = {});

/// True when geometry a and b provably stay further apart than `apart` [m] in every configuration within the limits.
/// Branch and bound over the joints between them, with at most `budget` distance evaluations. False when they come
/// nearer, or when the budget does not suffice for a proof.
[[nodiscard]] bool proven_apart(const RobotModel& model, int a, int b, const PairDistance& distance, double apart,
                                int budget);

}  // namespace hecaton::planner
