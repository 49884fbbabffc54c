#pragma once
/// Poses for the draft of a cell: compact, clear, and with round numbers where they can have them.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/model/arm.hpp"
#include "services/config/overlaps.hpp"

namespace hecaton::services::cli {

/// Chooses poses of the arms that are clear of themselves, of obstacles, and of other arms in the pose of that name.
/// Deterministic.
class PoseFinder {
 public:
  PoseFinder(const std::vector<planner::Arm>& arms, std::vector<world::Obstacle> obstacles);

  /// For each arm its own pose `name` if that is clear, else one that is; empty when an arm has none. `arms`: those of
  /// the constructor, with the poses that they have by now. In a chosen pose links of the arm keep what lets it come to
  /// rest there, where the arm has such a pose. One other than `home` is away from `home`: a link or the tool moves
  /// visibly where the arm has such a pose.
  [[nodiscard]] std::optional<std::vector<planner::JointVector>> find(const std::vector<planner::Arm>& arms,
                                                                      const std::string& name) const;

 private:
  using Placed = std::vector<std::vector<config::PosedBody>>;  ///< of the arms that have a pose

  [[nodiscard]] std::vector<config::PosedBody> bodies(int arm, const planner::JointVector& q) const;
  /// Distances that a pose should have [m].
  struct Wanted {
    double of_itself;
    double share;  ///< at most this share of the widest distance of two links that are always close
    double of_others;
  };
  [[nodiscard]] bool clear(int arm, const planner::JointVector& q, const Placed& placed, const Wanted& wanted) const;
  [[nodiscard]] std::optional<planner::JointVector> find_one(const planner::Arm& model, int arm,
                                                             const std::string& name, const Placed& placed) const;
  /// The most compact posture that is usable and clear, with round numbers where it can have them. `margin`: to the
  /// security distance between links of the arm [m]; empty: these may come nearer.
  [[nodiscard]] std::optional<planner::JointVector> find_compact(
      const planner::Arm& model, int arm, const Placed& placed,
      const std::function<bool(const planner::JointVector&)>& usable, std::optional<double> margin) const;

  std::vector<world::Obstacle> obstacles_;
  std::vector<planner::CellGeometry> geometries_;
  std::vector<std::vector<planner::JointVector>> postures_;  ///< of each arm, the most compact first
};

}  // namespace hecaton::services::cli
