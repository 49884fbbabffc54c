#pragma once
/// Which global planners there are: the command line and the tests ask here.

#include <memory>
#include <vector>

#include "planner/global/global_planner.hpp"

namespace hecaton::planner::global {

/// A value: a program that has planners of its own copies built_in_planners() and adds them.
class PlannerRegistry {
 public:
  using Shared = std::shared_ptr<const GlobalPlanner>;

  /// Throws std::invalid_argument when there is a planner of the same name.
  void add(Shared planner);
  template <class Planner>
  void add() {
    add(std::make_shared<const Planner>());
  }

  /// In the order of their registration.
  [[nodiscard]] const std::vector<Shared>& planners() const { return planners_; }
  /// The planner of that name. Throws std::invalid_argument that lists the names when there is none.
  [[nodiscard]] const Shared& at(std::string_view name) const;

 private:
  std::vector<Shared> planners_;
};

/// Those of Hecaton, with default parameters. Thread-safe.
[[nodiscard]] const PlannerRegistry& built_in_planners();

/// RRT-Connect with default parameters. Thread-safe.
[[nodiscard]] std::shared_ptr<const GlobalPlanner> default_planner();

}  // namespace hecaton::planner::global
