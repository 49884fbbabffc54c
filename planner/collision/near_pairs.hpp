#pragma once
/// Finds the pairs of bodies that may be nearer than the influence distance, by bounding volumes alone: the first half
/// of every distance pass, common to all exact kernels.

#include <algorithm>
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

/// How near is near, as a function of how fast the own body can move: what may soon collide matters farther away.
struct Reach {
  double at_rest = 0.0;    ///< never less than this [m]
  double moving = 0.0;     ///< [m]
  double per_speed = 0.0;  ///< [s]
  [[nodiscard]] double at(double speed) const { return std::max(at_rest, moving + per_speed * speed); }
};

/// The influence distances of a pass. Without own speeds: `others` and `self`, whatever moves.
struct InfluenceDistances {
  double others = 0.0;                   ///< against obstacles and other arms [m]
  double self = 0.0;                     ///< between bodies of the own arm [m]
  std::span<const double> own_speed{};   ///< no point of own body i moves faster [m/s]; empty, or one per own body and:
  std::span<const Reach> of_arm{};       ///< one per arm of the cell
  std::span<const Reach> of_obstacle{};  ///< one per obstacle
  Reach of_self{};                       ///< of the sum of both bodies' speeds

  [[nodiscard]] double against_self(int first, int second) const {
    return own_speed.empty() ? self : of_self.at(own_speed[first] + own_speed[second]);
  }
  [[nodiscard]] double against_arm(int own, int arm) const {
    return own_speed.empty() ? others : of_arm[arm].at(own_speed[own]);
  }
  [[nodiscard]] double against_obstacle(int own, int obstacle) const {
    return own_speed.empty() ? others : of_obstacle[obstacle].at(own_speed[own]);
  }
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
