#pragma once
/// Algorithm 3 of [Li96], running: an arm that knows no obstacle but what its sensors see. It keeps a way through the
/// cells that are not known to be blocked, and searches another when what it sees blocks that one.

#include <optional>
#include <string>
#include <vector>

#include "planner/methods/motion_method.hpp"
#include "planner/methods/sensed_cspace/cspace_search.hpp"
#include "planner/methods/sensed_cspace/sensed_map.hpp"
#include "planner/model/arm.hpp"
#include "planner/model/kinematics.hpp"

namespace hecaton::planner::cspace {

class SensedPlanner : public MotionGuide {
 public:
  /// `dt`: control period [s]. The arm's model must be one that ArmPlanes takes.
  SensedPlanner(const Arm& arm, const SensedParameters& parameters, double dt);

  /// What a sensor of the arm has measured.
  void sense(const RangeScan& scan) override;
  /// A point of an obstacle in W [m], from whoever else knows one.
  void see(const Eigen::Vector3d& p_W);

  using Path = GuidedPath;
  [[nodiscard]] Aim guide(const JointVector& q, const JointVector& qd, const JointVector& q_goal) override;

  /// From `from`, the arm may come to (q, q̇) at the end of a period: it could still stop in cells that are not known to
  /// be blocked. Out of a blocked cell it always may, slowly. Nowhere while something that was seen is not mapped yet.
  [[nodiscard]] bool may_go(const JointVector& from, const JointVector& q, const JointVector& qd) const override;

  [[nodiscard]] std::optional<std::string> why_none(const JointVector& q) const override;

  [[nodiscard]] const SensedMap& map() const { return known_.map(); }
  [[nodiscard]] const std::vector<Cell3>& path() const { return path_; }
  [[nodiscard]] int searches() const { return searches_; }       ///< begun so far
  [[nodiscard]] std::int64_t mapped() const { return mapped_; }  ///< points that were mapped so far, times planes

 private:
  [[nodiscard]] Aim choose(const JointVector& q, const JointVector& qd, const JointVector& q_goal);
  void model();
  void model_anew(int& points);
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
  std::optional<GrowingMap> anew_;  ///< of an arm that forgets: takes the place of what it knows when it is complete
  bool modelling_anew_ = false;
  CspaceSearch search_;
  std::vector<std::vector<Eigen::Vector3d>> now_;  ///< what each sensor saw last, in B [m]
  bool changed_ = false;                           ///< since `anew_` was begun from `now_`
  std::int64_t mapped_ = 0;
  bool detours_ = false;       ///< something has come in the straight way, see Remember
  double nearest_ = 0.0;       ///< a detour ends nearer to the goal than this [rad]
  bool blocked_more_ = false;  ///< since the way was checked
  bool forgot_ = false;        ///< since the search began
  bool straight_ = false;      ///< the straight way to the goal was free
  bool none_ = false;          ///< there was no way
  bool careful_ = false;       ///< the way is gone from rest to rest
  int standing_ = 0;           ///< periods at rest with somewhere to go
  JointVector q_goal_;
  std::vector<Cell3> path_;
  std::vector<JointVector> trail_;  ///< where the arm was, in cells that were free
  std::size_t at_ = 0;              ///< the farthest point of the way that was in sight
  int searches_ = 0;
  Kinematics kinematics_;  ///< scratch
};

}  // namespace hecaton::planner::cspace
