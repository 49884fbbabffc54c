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
  int samples = 500;  ///< random configurations
  std::uint64_t random_seed = 1;
  double always = 0.95;     ///< a pair that touches in this share of the samples counts as always touching
  double contact = 5e-3;    ///< nearer than this, enclosing shapes cannot tell whether links touch [m]
  double apart = 0.02;      ///< the filter drops pairs that provably never come nearer than this [m]
  int proof_budget = 2000;  ///< distance evaluations per pair; the filter keeps pairs whose proof needs more
  double close = 0.25;      ///< pairs whose distance never exceeds this are listed as close [m]
  double adjacent = 0.05;  ///< below this widest distance [m] a pair needs no margin, only a proof that it cannot touch
  double touching = 1e-3;  ///< least distance of a pair that provably cannot touch [m]
  int close_budget = 20000;  ///< distance evaluations for each proof that a pair never touches, or is adjacent
};

/// Removes four kinds of pairs from model.self_pairs:
/// - pairs that touch, or nearly touch, in nearly every sampled configuration: their shapes overlap by construction;
/// - pairs that provably stay apart in all configurations within the limits;
/// - pairs with two joints between them, such as a base and an upper arm, that provably never touch: where those joints
///   bring them near, no other joint parts them, so that the arm could not pass;
/// - adjacent pairs, which no posture brings far apart, that provably never touch.
/// A pair without proof stays, even if no sample touches. Then lists the close pairs among the rest in close_pairs, and
/// narrows limits of joints whose other turns no motion reaches. Adds notes and details. Deterministic for a
/// random_seed.
void automatic_filter(RobotModel& model, const PairDistance& distance, const FilterOptions& options = {});

/// True when geometry a and b provably stay further apart than `apart` [m] in every configuration within the limits.
/// Branch and bound over the joints between them, with at most `budget` distance evaluations. False when they come
/// nearer, or when the budget does not suffice for a proof.
[[nodiscard]] bool proven_apart(const RobotModel& model, int a, int b, const PairDistance& distance, double apart,
                                int budget);

/// The same for the opposite: geometry a and b provably never get farther apart than `within` [m].
[[nodiscard]] bool proven_within(const RobotModel& model, int a, int b, const PairDistance& distance, double within,
                                 int budget);

}  // namespace hecaton::planner
