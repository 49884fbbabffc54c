#pragma once
/// A way around everything as it stands now, for one arm or for several as one: what a planner that does not come
/// nearer asks beside its ticks.

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

/// What the planner knows when it asks.
struct RouteQuestion {
  std::vector<int> planned;                     ///< arms to be moved, as indices in the cell; the own one is among them
  JointPoint q;                                 ///< from here
  JointPoint q_goal;                            ///< to here
  std::vector<JointPoint> left;                 ///< of the route under way, up to the goal; empty: there is none
  std::vector<JointVector> arms;                ///< of the whole cell, where they are by now; empty: to be left out
  std::vector<world::ObstacleState> obstacles;  ///< of the whole cell, where they are by now
  std::uint64_t seed = 1;
};

struct RouteAnswer {
  enum class Kind : std::uint8_t {
    kStraight,  ///< nothing stands in the straight way
    kKept,      ///< the rest of the route is free, and may be shorter than before
    kFound,     ///< another one
    kNone,      ///< none was found
  };
  Kind kind = Kind::kNone;
  /// kKept and kFound, and kStraight of several arms: after q, up to the goal. Of several arms no point is farther from
  /// the last one than they may go without waiting for each other.
  std::vector<JointPoint> points;
  std::uint64_t checks = 0;  ///< configurations looked at
};

/// Where arm i is by now if it continues as it was seen, within its limits [rad | m].
[[nodiscard]] inline JointVector extrapolated_position(const CellGeometry& geometry, std::span<const ArmObservation> arms, int i) {
  const JointLimits& limits = geometry.arms()[i].limits;
  return (arms[i].q + arms[i].qd * arms[i].age).cwiseMax(limits.lower).cwiseMin(limits.upper);
}

/// Likewise where the obstacles are.
[[nodiscard]] inline std::vector<world::ObstacleState> extrapolated_obstacles(std::span<const world::ObstacleState> obstacles) {
  std::vector<world::ObstacleState> states(obstacles.begin(), obstacles.end());
  for (world::ObstacleState& state : states) state.X_WO = world::extrapolate(state.X_WO, state.velocity, state.age);
  return states;
}

class RouteSearch {
 public:
  /// `arms`, `parameters`: of the whole cell; `self`: index of the own arm.
  RouteSearch(std::vector<Arm> arms, std::vector<LocalParameters> parameters, int self);

  /// What planned arms carry is part of them.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// The same question has the same answer on every machine. Ways that keep more distance are looked for first. Throws
  /// std::invalid_argument when the planned arms have more joints than global::kMostDimensions.
  [[nodiscard]] RouteAnswer answer(const RouteQuestion& question);

 private:
  using Configuration = std::vector<double>;  // of all planned arms, one after the other
  void build(const std::vector<int>& planned);
  [[nodiscard]] Configuration joined(const JointPoint& point) const;
  [[nodiscard]] JointPoint parted(const Configuration& q) const;
  [[nodiscard]] Configuration nearest_turn(const Configuration& from, const Configuration& to) const;
  [[nodiscard]] bool straight(int level, const Configuration& a, const Configuration& b) const;
  [[nodiscard]] std::optional<std::vector<JointPoint>> keep(const RouteQuestion& question) const;
  [[nodiscard]] std::optional<Configuration> beside(int level, const Configuration& q, Random& random) const;
  [[nodiscard]] std::vector<JointPoint> divided(const std::vector<Configuration>& points) const;
  [[nodiscard]] std::optional<std::vector<JointPoint>> search(int level, const RouteQuestion& question);
  [[nodiscard]] global::Plan plan(int level, const Configuration& from, const Configuration& to, std::uint64_t seed);
  [[nodiscard]] global::Plan plan_in_turns(int level, const Configuration& from, const Configuration& to,
                                           const global::PlanOptions& options);
  [[nodiscard]] std::uint64_t checks() const;

  std::vector<Arm> arms_;
  std::vector<LocalParameters> parameters_;
  int self_;
  std::vector<world::Obstacle> obstacles_;
  CellGeometry geometry_;                 ///< of the own arm: everybody's bodies
  std::vector<int> planned_;              ///< of `levels_`
  std::vector<double> lower_, upper_;     ///< of all planned joints [rad | m]
  std::vector<global::Validity> levels_;  ///< from the most distance that is kept to the least; empty: not built yet
  std::vector<std::unique_ptr<global::SuperGraph>> graphs_;  ///< by level, of several arms; null: not built yet
  std::vector<global::WorldBody> world_;                     ///< of the present question
  std::uint64_t expansions_ = 0;                             ///< of the present question
};

}  // namespace hecaton::planner
