#pragma once
/// Finds the pairs of bodies that may be nearer than the influence distance, by bounding volumes alone: the first half
/// of every distance pass, common to all exact kernels.

#include <span>
#include <utility>
#include <vector>

#include "planner/collision/cell_geometry.hpp"

namespace hecaton::planner {

/// Where everything is during one distance pass. Foreign arms by cell index; the entry of the own arm is ignored.
struct CellPoses {
  const Kinematics* own = nullptr;
  std::span<const Kinematics> arms;                 ///< one per arm of the cell
  std::span<const world::ObstacleState> obstacles;  ///< one per obstacle of the CellGeometry
};

/// How near is near [m].
struct InfluenceDistances {
  double others = 0.0;                     ///< against obstacles and other arms
  double self = 0.0;                       ///< between bodies of the own arm
  std::span<const double> extra_of_arm{};  ///< added to `others` against arm i of the cell; may be empty
};

/// A body of the cell in the pass's flat list.
struct CellBody {
  Counterpart counterpart = Counterpart::kObstacle;  ///< what the body is to the own arm; kSelf: its own
  int owner = 0;                                     ///< arm or obstacle index
  int index = 0;                                     ///< among the owner's bodies
  int link = -1;                                     ///< −1: obstacle
  bool moves = true;
  Pose X_CS = Pose::Identity();                          ///< shape S in its carrier (link or obstacle) C
  world::BoundingSphere bound;                           ///< in C
  Eigen::Vector3d box_centre = Eigen::Vector3d::Zero();  ///< of the bounding box in S [m]
  Eigen::Vector3d box_half = Eigen::Vector3d::Zero();    ///< its half extents [m]
};

struct NearPair {
  int own = 0;         ///< index into NearPairs::bodies()
  int other = 0;       ///< index into NearPairs::bodies()
  double limit = 0.0;  ///< the pair's influence distance [m]
};

/// Which pairs exist (decided when built) and which are near (found every pass). One per thread; `find` does not
/// allocate. Bodies of the own arm that no joint moves are not paired with obstacles nor with bodies of other arms that
/// do not move either; self pairs are those of the geometry.
class NearPairs {
 public:
  explicit NearPairs(const CellGeometry& geometry);

  /// All candidates, ordered: self pairs, then other bodies in cell order, each with own bodies in order. A pair that
  /// is left out is certainly farther than its limit. Valid until the next call.
  std::span<const NearPair> find(const CellPoses& poses, const InfluenceDistances& influence);

  /// Own bodies, other arms' bodies, obstacles' bodies.
  [[nodiscard]] const std::vector<CellBody>& bodies() const { return bodies_; }
  /// X_WS [m] of a body of a pair that the last `find` returned.
  [[nodiscard]] const Pose& pose(int body) const { return X_WS_[body]; }

 private:
  void place(int body, const CellPoses& poses);
  [[nodiscard]] bool boxes_are_near(int a, int b, double limit) const;
  void consider(int own, int other, double limit);

  std::vector<CellBody> bodies_;
  int own_count_ = 0;
  std::vector<std::pair<int, int>> self_pairs_;
  std::vector<Pose> X_WS_;
  std::vector<Eigen::Vector3d> centre_W_;
  std::vector<NearPair> pairs_;
};

}  // namespace hecaton::planner
