#pragma once
/// A way around everything as it stands now: what a planner that does not come nearer asks beside its ticks.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "planner/collision/cell_geometry.hpp"
#include "planner/global/plan.hpp"
#include "planner/local/observation.hpp"
#include "planner/local/parameters.hpp"

namespace hecaton::planner {

/// What the planner knows when it asks.
struct RouteQuestion {
  JointVector q;                                ///< from here [rad | m]
  JointVector q_goal;                           ///< to here
  std::vector<JointVector> left;                ///< of the route under way, up to the goal; empty: there is none
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
  std::vector<JointVector> points;  ///< kKept and kFound: the last one is the goal [rad | m]
  std::uint64_t checks = 0;         ///< configurations looked at
};

class RouteSearch {
 public:
  /// `arms`: of the whole cell; `self`: index of the own one.
  RouteSearch(std::vector<Arm> arms, int self, const LocalParameters& parameters);

  /// What the own arm carries is part of it.
  void set_obstacles(std::span<const world::Obstacle> obstacles);

  /// The same question has the same answer on every machine. Ways that keep more distance are looked for first.
  [[nodiscard]] RouteAnswer answer(const RouteQuestion& question);

 private:
  void build();
  [[nodiscard]] bool straight(int level, const JointVector& a, const JointVector& b) const;
  [[nodiscard]] std::optional<std::vector<JointVector>> keep(const RouteQuestion& question) const;
  [[nodiscard]] std::optional<JointVector> beside(int level, const JointVector& q, Random& random) const;
  [[nodiscard]] std::optional<std::vector<JointVector>> search(int level, const RouteQuestion& question) const;
  [[nodiscard]] std::uint64_t checks() const;

  CellGeometry geometry_;
  LocalParameters parameters_;
  std::vector<global::Validity> levels_;  ///< from the most distance that is kept to the least; empty: not built yet
};

}  // namespace hecaton::planner
