#pragma once
/// Bodies of a cell that overlap: at the start, in named poses, and where the user adds or moves an obstacle.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "planner/cell.hpp"
#include "planner/collision/cell_geometry.hpp"
#include "planner/local/parameters.hpp"

namespace hecaton::config {

/// A body of the cell at a pose.
struct PosedBody {
  planner::Body body;
  world::Pose X_WS = world::Pose::Identity();
  std::string name;  ///< "left/forearm", "pillar"
};

/// Two bodies and their distance.
struct NearestPair {
  bool found = false;
  std::string a;
  std::string b;
  double distance = 0.0;  ///< [m]; negative: depth of penetration
};

/// Bodies of the arm at joint positions q, then those of carried obstacles. `obstacles`: those of the geometry.
[[nodiscard]] std::vector<PosedBody> place_arm(std::span<const world::Obstacle> obstacles,
                                               const planner::CellGeometry& geometry, int arm,
                                               const planner::JointVector& q);

/// Bodies of the geometry's obstacle `index`, which is not attached.
[[nodiscard]] std::vector<PosedBody> place_obstacle(const planner::CellGeometry& geometry, const std::string& name,
                                                    const world::Pose& X_WO, int index);
/// The same at t = 0.
[[nodiscard]] std::vector<PosedBody> place_obstacle(const planner::CellGeometry& geometry,
                                                    const world::Obstacle& obstacle, int index);

/// The nearest pair of a body of a and a body of b that are nearer than `within` [m]. `moving_a_only` ignores bodies of
/// a that no joint moves.
[[nodiscard]] NearestPair nearest_pair(const std::vector<PosedBody>& a, const std::vector<PosedBody>& b, double within,
                                       bool moving_a_only);

/// The same for all bodies of arms a and b; for arms of one robot only for bodies that joints move.
[[nodiscard]] NearestPair nearest_pair_of_arms(const planner::Arm& a, const std::vector<PosedBody>& bodies_a,
                                               const planner::Arm& b, const std::vector<PosedBody>& bodies_b,
                                               double within);

/// The deepest overlap of an obstacle with an arm's bodies that a joint moves. Other bodies of the arm may overlap
/// obstacles, as a base on a table does.
[[nodiscard]] NearestPair overlap_of_moving(const std::vector<PosedBody>& arm, const std::vector<PosedBody>& obstacle);

/// The nearest of the self pairs of the geometry's own arm, with its bodies, that is nearer than `within` [m]. A close
/// pair counts when it is nearer than `share` of its widest distance.
[[nodiscard]] NearestPair nearest_self_pair(const std::vector<PosedBody>& bodies, const planner::CellGeometry& geometry,
                                            double within, double share = planner::kSecurityShare);

/// "left/forearm and pillar overlap by 12.3 mm"
[[nodiscard]] std::string overlap_text(const NearestPair& pair);

/// Joint positions of each arm of a cell; empty for an arm without measurement.
using MeasuredJoints = std::span<const std::optional<planner::JointVector>>;

/// Checks a new pose X_WO of an obstacle in a running cell. It must not overlap a body that a joint moves, a carried
/// obstacle, or, unless the obstacle is static, an arm's fixed base. `others`: the cell's obstacles; those that arms
/// carry count. Returns a sentence such as "north/forearm and crate overlap by 12 mm"; empty without overlap.
[[nodiscard]] std::string overlap_with_arms(std::span<const planner::PlannedArm> arms, MeasuredJoints q,
                                            std::span<const world::Obstacle> others, const world::Obstacle& obstacle,
                                            const world::Pose& X_WO);

/// Removes the poses that only SRDFs name, in which the arm overlaps itself, and that neither a start nor the tasks
/// use. Adds a note for each.
void leave_out_poses(planner::Cell& cell, std::vector<std::string>& notes);

/// Checks that the cell can start. Throws ConfigError with both bodies and the depth when
/// - bodies of two arms that no joint moves overlap, unless they are arms of one robot,
/// - an arm overlaps itself at its start or in a named pose,
/// - at the start an arm overlaps another arm, or one of its moving bodies an obstacle,
/// - at a stop of the pose sequence an arm overlaps another arm, or one of its moving bodies a static obstacle.
/// `file` is for messages.
void check_start(const planner::Cell& cell, const std::string& file);

/// The pose of an obstacle that is not attached at t = 0, according to its motion.
[[nodiscard]] world::Pose initial_pose(const world::Obstacle& obstacle);

}  // namespace hecaton::config
