#pragma once
/// What an arm knows of its C-space: the cells that measured points block, by planes of θ₀ [Li96, sections 4 and 5].
/// Space that no sensor has measured counts as free.

#include <array>
#include <span>
#include <unordered_set>
#include <vector>

#include "planner/methods/sensed_cspace/arm_planes.hpp"
#include "planner/methods/sensed_cspace/obstacle_mapper.hpp"

namespace hecaton::planner {

/// How long an arm remembers what it saw (docs/design/0011-sensed-cspace.md says when it then arrives).
enum class Remember {
  kNever,        ///< it plans with what it sees now, as published: "We do not accumulate historical FO_i"
  kUntilNearer,  ///< from where something comes in its way until the goal is in sight and nearer than there
  kAlways,
};

/// What an arm knows of its C-space. The cell file's map `sensed`.
struct SensedParameters {
  int cells = 180;       ///< of a full turn of each joint, 36 to 1440, a multiple of 4
  double margin = 0.03;  ///< kept from what was seen, for what is between two beams [m], > 0
  Remember remember = Remember::kAlways;
};

}  // namespace hecaton::planner

namespace hecaton::planner::cspace {

/// A cell of the joints' ranges: how many cells each angle is from the first, θ₀ first.
using Cell3 = std::array<int, 3>;

class SensedMap {
 public:
  /// Nothing was seen. Joints without limits may turn once round either way.
  SensedMap(const ArmPlanes& planes, const JointLimits& limits, const SensedParameters& parameters);

  /// Sees a point of an obstacle in the arm's base frame B [m]. True: something is blocked that was free.
  bool see(const Eigen::Vector3d& p_B);
  void forget();
  /// Has seen this point, or another in the same small cube.
  [[nodiscard]] bool holds(const Eigen::Vector3d& p_B) const;
  /// Seeing these points after forgetting all would make the same map: the union of fundamental obstacles is the same.
  [[nodiscard]] bool holds_just(std::span<const Eigen::Vector3d> points_B) const;
  /// Points that were mapped since the last forget(), at most one in a small cube.
  [[nodiscard]] const std::vector<Eigen::Vector3d>& points() const { return points_; }

  [[nodiscard]] const Cell3& size() const { return size_; }  ///< cells of each angle
  [[nodiscard]] int index(const Cell3& cell) const { return (cell[0] * size_[1] + cell[1]) * size_[2] + cell[2]; }
  [[nodiscard]] Cell3 cell(int index) const;
  /// Which holds q; the nearest if q is beyond the limits.
  [[nodiscard]] Cell3 cell_at(const JointVector& q) const;
  [[nodiscard]] JointVector centre(const Cell3& cell) const;
  [[nodiscard]] double pitch() const { return grid_.pitch(); }
  /// Of a cell within size(). In a cell that is not blocked, the arm is clear of all points by the margin wherever in
  /// the cell it is.
  [[nodiscard]] bool blocked(const Cell3& cell) const {
    return planes_[cell[0]].blocked(wrapped_[1][cell[1]], wrapped_[2][cell[2]]);
  }
  /// All of the straight line lies in cells that are not blocked. `wide`: what is beside it, too, so that from wherever
  /// on the line the arm is, or a sixteenth of a cell aside, the rest of it still does.
  [[nodiscard]] bool straight_path_free(const JointVector& from, const JointVector& to, bool wide = false) const;

 private:
  [[nodiscard]] std::array<double, 3> places(const JointVector& q) const;
  [[nodiscard]] int nearest(int angle, double place) const;
  [[nodiscard]] bool any_blocked(const Cell3& first, const Cell3& last) const;

  ArmPlanes arm_;
  AngleGrid grid_;
  std::array<int, 3> first_{};  ///< first cell of each angle, not wrapped
  Cell3 size_{1, 1, 1};
  std::array<std::vector<std::int16_t>, 3> wrapped_;  ///< the grid's cell for each cell of an angle
  std::vector<CspaceMap> planes_;                     ///< one for each cell of θ₀
  std::vector<Turn> turns_;                           ///< of the planes
  double thick_ = 0.0;                                ///< added to the links across the planes [m]
  ObstacleMapper mapper_;
  std::unordered_set<std::uint64_t> seen_;  ///< small cubes
  std::vector<Eigen::Vector3d> points_;
  ObstacleImage image_;  ///< scratch
};

class GrowingMap {
 public:
  explicit GrowingMap(SensedMap map) : map_(std::move(map)) {}

  [[nodiscard]] const SensedMap& map() const { return map_; }
  /// Nothing waits.
  [[nodiscard]] bool complete() const { return waiting_.empty(); }

  /// A point that a sensor has seen from `distance` [m], in the arm's base frame B [m]; waits, unless it is known.
  void note(double distance, const Eigen::Vector3d& p_B);
  /// Puts a point into the map at once. True: something is blocked that was free.
  bool see(const Eigen::Vector3d& p_B) { return map_.see(p_B); }
  /// Puts up to `points` into the map, those nearest to their sensors first, and takes as many from `points`. True:
  /// something is blocked that was free.
  bool advance(int& points);
  /// Forgets everything, also what waits.
  void forget();

 private:
  struct Waiting {
    double distance;  ///< from the sensor [m]
    Eigen::Vector3d p_B;
  };

  SensedMap map_;
  std::vector<Waiting> waiting_;
};

}  // namespace hecaton::planner::cspace
