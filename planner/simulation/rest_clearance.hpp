#pragma once
/// Whether arms may rest where a task begins or ends: clear of themselves, of each other and of all places of
/// obstacles.

#include <array>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "planner/cell.hpp"
#include "planner/collision/exact_distance.hpp"
#include "planner/simulation/task_shortage.hpp"

namespace hecaton::planner {

/// One configuration per arm of the cell.
using CellConfiguration = std::vector<JointVector>;

/// Arms are numbered as in the cell. Clear means farther apart than the security distance of the dampers and a margin,
/// so that an arm can come to rest. A pair that no posture brings so far apart is clear when it is nearly as far apart
/// as it can be. Not thread-safe.
class RestClearance {
 public:
  /// `cell` must outlive this.
  explicit RestClearance(const Cell& cell);

  /// Arm i at `q` is clear of itself and of all places of obstacles. Counts the pair that is not, see obstructions().
  [[nodiscard]] bool clear_alone(int i, const JointVector& q);
  /// Arm i at `q` is clear of `others` at the configurations for which this or clear_alone() was asked last.
  [[nodiscard]] bool clear_of(int i, const JointVector& q, std::span<const int> others);
  /// The arms at `q` are clear of each other.
  [[nodiscard]] bool clear_of_each_other(const CellConfiguration& q);
  /// The arms at `q` are clear of the scripted obstacles at world time `time` [s].
  [[nodiscard]] bool clear_at(double time, const CellConfiguration& q);

  /// Arm i at `q` touches an obstacle at its first place, or has two own links nearer than their security distance:
  /// nothing that the arm does leads past there.
  [[nodiscard]] bool stopped_alone(int i, const JointVector& q);
  /// Notes in `touched` each arm that touches another one at `q`; with `obstacles`, or an obstacle at its first place.
  void note_touching(const CellConfiguration& q, bool obstacles, std::vector<bool>& touched);

  /// Pose of the tool of arm i at `q`, in the cell; valid until the next call.
  [[nodiscard]] const Pose& tool(int i, const JointVector& q);
  /// Two arms of the cell reach a common point.
  [[nodiscard]] bool can_meet() const { return can_meet_; }

  /// The pair that was too near in most questions clear_alone() about arm i since the last forget_obstructions().
  [[nodiscard]] Obstruction most_frequent_obstruction(int i) const;
  void forget_obstructions();

 private:
  using Widest = std::map<std::array<int, 3>, double>;  ///< [m], by own body, obstacle and its body

  [[nodiscard]] int arms() const { return static_cast<int>(cell_.arms.size()); }
  void place(int i, const JointVector& q);
  void place(const CellConfiguration& q);
  [[nodiscard]] double rest_distance(int i) const;
  [[nodiscard]] bool unavoidably_near(int i, const Clearance& pair) const;
  [[nodiscard]] Widest pairs_always_near(int i);
  void sweep_obstacles();
  void count_obstruction(int i, double distance, double self_distance);
  template <class Counts>
  bool near(int i, const InfluenceDistances& within, std::span<const world::ObstacleState> obstacles,
            const Counts& counts);

  const Cell& cell_;
  std::vector<CellGeometry> geometries_;  ///< one per arm as the own arm
  std::vector<ExactDistance> distances_;
  std::vector<Kinematics> kinematics_;
  std::vector<std::vector<world::ObstacleState>> sweep_;  ///< of all obstacles, one entry per sample of their motion
  std::array<Clearance, 8> found_;
  std::vector<Widest> always_near_;                                      ///< of each arm
  std::vector<std::map<std::array<int, 3>, Obstruction>> obstructions_;  ///< of each arm
  bool can_meet_ = false;
};

}  // namespace hecaton::planner
