#pragma once
/// What an arm knows of its C-space: the cells that measured points block, by planes of θ₀ [Li96, sections 4 and 5].
/// Space that no sensor has measured counts as free.

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <unordered_set>
#include <vector>

#include "planner/methods/sensed_cspace/arm_planes.hpp"
#include "planner/methods/sensed_cspace/obstacle_mapper.hpp"
#include "planner/methods/sensed_cspace/published/published_mapper.hpp"

namespace hecaton::planner {

/// How long an arm keeps measured points. docs/explanation/0011-sensed-cspace.md says when the arm reaches its goal.
enum class Remember {
  kNever,        ///< present scans only, as published: "We do not accumulate historical FO_i"
  kUntilNearer,  ///< from the start of a detour until the goal is visible and nearer than at its start
  kAlways,
};

/// How measured points become blocked cells.
enum class Mapper {
  kExact,      ///< ObstacleMapper: every cell in which the arm touches a point
  kPublished,  ///< as [Li96]: forty stored images, five critical points of each obstacle; misses cells
};

/// The cell file's map `sensed`.
struct SensedParameters {
  int cells = 180;       ///< of a full turn of each joint, 36 to 1440, a multiple of 4
  double margin = 0.03;  ///< distance from measured points, to cover the gaps between beams [m], > 0
  Remember remember = Remember::kAlways;
  Mapper mapper = Mapper::kExact;
};

}  // namespace hecaton::planner

namespace hecaton::planner::cspace {

/// Indices of a cell along θ₀, θ₁ and θ₂, within the joints' ranges.
using Cell3 = std::array<int, 3>;

/// The cells of C-space that measured points block, with one CspaceMap for each cell of θ₀. Points in the same small
/// cube count as one. Not thread-safe.
class SensedMap {
 public:
  /// An empty map. Joints without limits get one turn in each direction.
  SensedMap(const ArmPlanes& planes, const JointLimits& limits, const SensedParameters& parameters);

  /// Notes a point of an obstacle in the arm's base frame B [m], for map_noted(). Returns false, and does nothing, if
  /// the map holds it.
  bool note(const Eigen::Vector3d& p_B);
  /// Blocks the cells of the points noted since the last call. Returns true if cells may have become blocked.
  /// Mapper::kPublished groups these points: neighbours belong to the same obstacle.
  bool map_noted();
  /// Notes and maps a point.
  bool add(const Eigen::Vector3d& p_B) { return note(p_B) && map_noted(); }
  void forget();
  /// True if the map holds this point or another one in the same small cube.
  [[nodiscard]] bool holds(const Eigen::Vector3d& p_B) const;
  /// True if the map of these points alone would be the same.
  [[nodiscard]] bool holds_exactly(std::span<const Eigen::Vector3d> points_B) const;
  /// The noted points since the last forget(), at most one in each small cube [m].
  [[nodiscard]] const std::vector<Eigen::Vector3d>& points() const { return points_; }

  [[nodiscard]] const Cell3& size() const { return size_; }  ///< number of cells along each angle
  [[nodiscard]] int index(const Cell3& cell) const { return (cell[0] * size_[1] + cell[1]) * size_[2] + cell[2]; }
  [[nodiscard]] Cell3 cell(int index) const;
  /// The cell that holds q, or the nearest one if q is outside the limits.
  [[nodiscard]] Cell3 cell_at(const JointVector& q) const;
  [[nodiscard]] JointVector centre(const Cell3& cell) const;
  [[nodiscard]] double pitch() const { return grid_.pitch(); }
  /// Precondition: `cell` is within size(). Everywhere in a free cell, the arm keeps the margin from all points.
  [[nodiscard]] bool blocked(const Cell3& cell) const {
    return planes_[cell[0]].blocked(wrapped_[1][cell[1]], wrapped_[2][cell[2]]);
  }
  /// True if the whole straight line lies in free cells. `wide`: cells beside the line must be free, too. Then the rest
  /// of the line stays free from any position up to a sixteenth of a cell beside it.
  [[nodiscard]] bool straight_path_free(const JointVector& from, const JointVector& to, bool wide = false) const;

 private:
  [[nodiscard]] std::array<double, 3> places(const JointVector& q) const;
  [[nodiscard]] int nearest(int angle, double place) const;
  [[nodiscard]] bool any_blocked(const Cell3& first, const Cell3& last) const;
  bool map_exactly(const Eigen::Vector3d& p_B);
  bool map_as_published(std::span<const Eigen::Vector3d> obstacle_B);

  ArmPlanes arm_;
  AngleGrid grid_;
  std::array<int, 3> first_{};  ///< first cell of each angle, not wrapped
  Cell3 size_{1, 1, 1};
  std::array<std::vector<std::int16_t>, 3> wrapped_;  ///< the grid's cell for each cell of an angle
  std::vector<CspaceMap> planes_;                     ///< one for each cell of θ₀
  std::vector<Turn> turns_;                           ///< of the planes
  double thick_ = 0.0;                                ///< added to the links across the planes [m]
  ObstacleMapper mapper_;
  std::shared_ptr<const ImageDatabase> images_;  ///< of Mapper::kPublished; null: mapper_ maps
  std::unordered_set<std::uint64_t> seen_;       ///< small cubes
  std::vector<Eigen::Vector3d> points_;
  std::size_t mapped_ = 0;  ///< number of points_ that are mapped
  ObstacleImage image_;     ///< scratch
};

/// A map with a queue of new points, so that each control period maps a bounded number of them.
class GrowingMap {
 public:
  explicit GrowingMap(SensedMap map) : map_(std::move(map)) {}

  [[nodiscard]] const SensedMap& map() const { return map_; }
  /// The queue is empty.
  [[nodiscard]] bool complete() const { return waiting_.empty(); }

  /// Queues a point in the arm's base frame B [m], measured at `distance` [m] from its sensor, unless it is mapped.
  void note(double distance, const Eigen::Vector3d& p_B);
  /// Maps the points of an obstacle at once. Returns true if cells may have become blocked.
  bool add(std::span<const Eigen::Vector3d> points_B);
  /// Maps up to `points` queued points, nearest to their sensors first, and reduces `points` by their number. Returns
  /// true if cells may have become blocked.
  bool advance(int& points);
  /// Clears the map and the queue.
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
