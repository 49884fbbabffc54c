#pragma once
/// Algorithm 3 of [Li96] for a live arm that knows obstacles from its sensors only.

#include <optional>
#include <string>
#include <vector>

#include "planner/methods/motion_method.hpp"
#include "planner/methods/sensed_cspace/cspace_search.hpp"
#include "planner/methods/sensed_cspace/sensed_map.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/kinematics.hpp"

namespace hecaton::planner::cspace {

/// Follows a path through the free cells of a SensedMap, and searches another one when new points block it. Not
/// thread-safe.
class SensedPlanner : public MotionGuide {
 public:
  /// `dt`: control period [s]. Precondition: ArmPlanes::why_not(*arm.model) returns nothing.
  SensedPlanner(const Arm& arm, const SensedParameters& parameters, double dt);

  void sense(const RangeScan& scan) override;
  /// Adds points on the surface of a known obstacle in W [m].
  void add_obstacle(std::vector<Eigen::Vector3d> points_W);

  using Path = GuidedPath;
  [[nodiscard]] Aim guide(const JointVector& q, const JointVector& qd, const JointVector& q_goal) override;

  /// True if all points are mapped and the stop from (q, q̇) stays in free cells, or if the arm slowly leaves a blocked
  /// cell.
  [[nodiscard]] bool may_go(const JointVector& from, const JointVector& q, const JointVector& qd) const override;

  [[nodiscard]] std::optional<std::string> no_path_reason(const JointVector& q) const override;

  [[nodiscard]] const SensedMap& map() const { return known_.map(); }
  [[nodiscard]] const std::vector<Cell3>& path() const { return path_; }
  [[nodiscard]] int searches() const { return searches_; }       ///< number of searches since construction
  [[nodiscard]] std::int64_t mapped() const { return mapped_; }  ///< mapped points times planes since construction

 private:
  [[nodiscard]] Aim choose(const JointVector& q, const JointVector& qd, const JointVector& q_goal);
  void model();
  void rebuild_map(int& points);
  void begin(const JointVector& q_goal);
  void drop_path();
  void remember_place(const JointVector& q);
  [[nodiscard]] Aim go_back(const JointVector& q, const JointVector& qd);
  void note_progress(const JointVector& q, bool straight);
  void search_from(const JointVector& q);
  [[nodiscard]] bool search_on();
  [[nodiscard]] bool look_ahead(const JointVector& q);
  [[nodiscard]] bool stands(const JointVector& q, const JointVector& qd, const JointVector& target);
  [[nodiscard]] bool path_free() const;
  [[nodiscard]] JointVector path_point(std::size_t i) const;
  [[nodiscard]] JointVector ahead(const JointVector& q, const JointVector& qd, const JointVector& target) const;

  Pose X_WB_, X_BW_;
  std::shared_ptr<const RobotModel> model_;
  JointLimits limits_;
  double dt_;
  Remember remember_;
  ArmPlanes planes_;
  GrowingMap known_;
  std::optional<GrowingMap> rebuilt_;  ///< of an arm that forgets: replaces known_ when complete
  bool rebuilding_ = false;
  CspaceSearch search_;
  std::vector<std::vector<Eigen::Vector3d>> now_;  ///< last scan of each sensor, in B [m]
  bool changed_ = false;                           ///< new scans since rebuilt_ was begun
  std::int64_t mapped_ = 0;
  bool detours_ = false;       ///< an obstacle has blocked the straight line, see Remember
  double nearest_ = 0.0;       ///< a detour ends nearer to the goal than this [rad]
  bool blocked_more_ = false;  ///< cells were blocked since the last check of the path
  bool forgot_ = false;        ///< cells were freed since the search began
  bool straight_ = false;      ///< the straight line to the goal is free
  bool none_ = false;          ///< there is no path
  bool careful_ = false;       ///< the arm stops at each point of the path
  int standing_ = 0;           ///< periods at rest away from the target
  JointVector q_goal_;
  std::vector<Cell3> path_;
  std::vector<JointVector> trail_;  ///< past positions in free cells
  std::size_t at_ = 0;              ///< index of the farthest visible point of the path
  int searches_ = 0;
  Kinematics kinematics_;  ///< scratch
};

}  // namespace hecaton::planner::cspace
