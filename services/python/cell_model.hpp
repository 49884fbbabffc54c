#pragma once
/// A cell file without a network: kinematics, distances, plans and simulations for the Python package. No Python in
/// here.

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "planner/global/plan.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/simulation/batch.hpp"
#include "planner/trajectory/jerk_limited.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/validate.hpp"

namespace hecaton::python {

/// Joint positions by arm [rad | m].
using Positions = std::map<std::string, std::vector<double>>;

/// What is asked of inverse kinematics.
struct InverseQuery {
  std::optional<std::vector<double>> start;  ///< begin of the search; empty: where the arm starts [rad | m]
  planner::FreeRotation free_rotation = planner::FreeRotation::kNone;
  double position_tolerance = 1e-4;     ///< [m]
  double orientation_tolerance = 1e-3;  ///< [rad]
  bool collision_free = true;           ///< clear of the arm itself, obstacles and fixed links of other arms
  int seeds = 32;                       ///< random restarts
};

/// What is asked of the global planner.
struct PlanQuery {
  Positions goal;                     ///< of one or several arms, which are planned together
  Positions start;                    ///< of any arm; other arms are where they start in the cell file
  std::optional<std::string> method;  ///< name of a global planner; empty: the default
  std::uint64_t seed = 1;
  double budget = 10.0;    ///< [s]
  double clearance = 0.0;  ///< from obstacles and between arms [m]
};

/// The answer: joint positions of all planned arms, in the cell's order.
struct PlanAnswer {
  std::vector<std::string> arms;           ///< planned arms, in the cell's order
  std::vector<int> joints;                 ///< of each
  planner::global::Plan plan;              ///< status, reason, path
  planner::AveragedTrajectory trajectory;  ///< along the path; empty without one
  /// Smallest distance on the path, without pairs of links of one arm [m]; infinite without a path.
  double clearance = std::numeric_limits<double>::infinity();
};

/// A loaded cell file. Constant, so that threads may share it. Functions throw InvalidArgument for unknown arms and
/// wrong numbers of joints.
class CellModel {
 public:
  /// Throws config::ConfigError.
  explicit CellModel(const std::string& path);

  [[nodiscard]] const planner::Cell& cell() const { return file_.cell; }
  /// What `hecaton check` finds in the file, errors first.
  [[nodiscard]] std::vector<config::Finding> check() const;
  [[nodiscard]] const planner::PlannedArm& arm(const std::string& name) const;
  /// Where the arm starts [rad | m].
  [[nodiscard]] planner::JointVector start(const std::string& arm) const;

  /// All frames of the arm at q.
  [[nodiscard]] planner::Kinematics forward(const std::string& arm, const std::vector<double>& q) const;
  /// 6 × n, rows [ω; v], of the tool frame in W.
  [[nodiscard]] planner::FrameJacobian jacobian(const std::string& arm, const std::vector<double>& q) const;
  /// Joint positions within the limits that bring the tool to X_WT; empty when none is found before a stop.
  [[nodiscard]] std::optional<planner::JointVector> inverse(const std::string& arm, const planner::Pose& X_WT,
                                                            const InverseQuery& query,
                                                            const std::stop_token& stop) const;
  /// The nearest pair of bodies of the cell with obstacles at t = 0. Arms that `positions` leaves out are where they
  /// start.
  [[nodiscard]] planner::global::Validity::Nearest nearest(const Positions& positions) const;
  /// Throws InvalidArgument for a query without goal, std::invalid_argument for an unknown planner.
  [[nodiscard]] PlanAnswer plan(const PlanQuery& query, const std::stop_token& stop) const;
  /// Simulates random tasks of the cell in virtual time. Throws InvalidArgument when no task can be drawn.
  [[nodiscard]] planner::BatchReport simulate(int tasks, std::uint64_t seed, int threads,
                                              const std::stop_token& stop) const;

 private:
  [[nodiscard]] int index(const std::string& arm) const;
  [[nodiscard]] planner::JointVector joints(int arm, const std::vector<double>& q) const;
  /// Of every arm: those of `positions`, else where it starts.
  [[nodiscard]] std::vector<planner::JointVector> configuration(const Positions& positions) const;
  [[nodiscard]] planner::global::Validity validity(const std::vector<int>& planned,
                                                   std::vector<planner::JointVector> others, double clearance) const;

  config::CellFile file_;
};

}  // namespace hecaton::python
