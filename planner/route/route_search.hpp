#pragma once
/// Routes: paths among all bodies at their present places, for one arm or for several together. A planner without
/// progress asks for them outside its ticks.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/global/plan.hpp"
#include "planner/global/super_graph.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"

namespace hecaton::planner {

/// The configurations of the planned arms, in their order [rad | m].
using JointPoint = std::vector<JointVector>;

/// A snapshot of the cell, as the planner knows it.
struct RouteQuestion {
  std::vector<int> planned;                     ///< indices of the arms to move; contains the own arm
  JointPoint q;                                 ///< start
  JointPoint q_goal;                            ///< goal
  std::vector<JointPoint> remaining;            ///< points of the route under way, up to the goal; empty: none
  std::vector<JointVector> arms;                ///< all arms of the cell, extrapolated to now; empty: leave out
  std::vector<world::ObstacleState> obstacles;  ///< all obstacles of the cell, extrapolated to now
  std::uint64_t seed = 1;
};

struct RouteAnswer {
  enum class Kind : std::uint8_t {
    kStraight,  ///< the straight edge to the goal is free
    kKept,      ///< the remaining route is free; it may have been shortened
    kFound,     ///< a new route
    kNone,      ///< no route was found
  };
  Kind kind = Kind::kNone;
  /// With kKept and kFound, and with kStraight of several arms: the points after q, up to the goal. Several arms must
  /// wait for each other at each point.
  std::vector<JointPoint> points;
  std::uint64_t checks = 0;  ///< configurations checked
};

/// The position of arm i extrapolated to now at its last velocity, within its limits [rad | m].
[[nodiscard]] inline JointVector extrapolated_position(const CellGeometry& geometry,
                                                       std::span<const ArmObservation> arms, int i) {
  const JointLimits& limits = geometry.arms()[i].limits;
  return (arms[i].q + arms[i].qd * arms[i].age).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

/// The obstacles extrapolated to now at their last velocities.
[[nodiscard]] inline std::vector<world::ObstacleState> extrapolated_obstacles(
    std::span<const world::ObstacleState> obstacles) {
  std::vector<world::ObstacleState> states(obstacles.begin(), obstacles.end());
  for (world::ObstacleState& state : states) state.X_WO = world::extrapolate(state.X_WO, state.velocity, state.age);
  return states;
}

/// Answers questions of one planner. Not thread-safe; keeps collision models between questions about the same arms.
class RouteSearch {
 public:
  /// `arms`, `parameters`: of the whole cell; `self`: index of the own arm.
  RouteSearch(std::vector<Arm> arms, std::vector<LocalParameters> parameters, int self);

  /// Replaces the obstacles. An obstacle that a planned arm carries is part of that arm.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// Searches with decreasing clearance. The same question gives the same answer on processors with the same lanes of
  /// floats (global::fastest_validity); on others, where rounding does not decide. Throws std::invalid_argument if the
  /// planned arms have more than global::kMaxDimensions joints.
  [[nodiscard]] RouteAnswer answer(const RouteQuestion& question);

 private:
  using Configuration = std::vector<double>;  // of all planned arms, concatenated
  void build(const std::vector<int>& planned);
  [[nodiscard]] Configuration concatenated(const JointPoint& point) const;
  [[nodiscard]] JointPoint split(const Configuration& q) const;
  [[nodiscard]] Configuration nearest_turn(const Configuration& from, const Configuration& to) const;
  [[nodiscard]] bool edge_free(int level, const Configuration& a, const Configuration& b) const;
  [[nodiscard]] std::optional<std::vector<JointPoint>> keep(const RouteQuestion& question) const;
  [[nodiscard]] std::optional<Configuration> free_near(int level, const Configuration& q, Random& random) const;
  [[nodiscard]] std::vector<JointPoint> divided(const std::vector<Configuration>& points) const;
  [[nodiscard]] std::optional<std::vector<JointPoint>> search(int level, const RouteQuestion& question);
  [[nodiscard]] global::Plan plan(int level, const Configuration& from, const Configuration& to, std::uint64_t seed);
  [[nodiscard]] global::Plan plan_by_roadmaps(int level, const Configuration& from, const Configuration& to,
                                              const global::PlanOptions& options);
  [[nodiscard]] std::uint64_t checks() const;

  std::vector<Arm> arms_;
  std::vector<LocalParameters> parameters_;
  int self_;
  std::vector<world::Obstacle> obstacles_;
  CellGeometry geometry_;                 ///< of the own arm, with the bodies of all arms
  std::vector<int> planned_;              ///< for which levels_ were built
  std::vector<double> lower_, upper_;     ///< of all planned joints [rad | m]
  std::vector<global::Validity> levels_;  ///< by decreasing clearance, and one for the ends; empty: not built yet
  std::vector<std::unique_ptr<global::SuperGraph>> graphs_;  ///< by level; null: not built yet
  std::vector<global::WorldBody> world_;                     ///< of the present question
  std::uint64_t expansions_ = 0;                             ///< of the present question
};

}  // namespace hecaton::planner
