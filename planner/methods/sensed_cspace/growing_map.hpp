#pragma once
/// A map, and what was seen and waits to be put into it: a share of the work at a time.

#include <vector>

#include "planner/methods/sensed_cspace/sensed_map.hpp"

namespace hecaton::planner::cspace {

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
