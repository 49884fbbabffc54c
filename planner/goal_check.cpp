#include "planner/goal_check.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>
#include <vector>

#include "planner/collision/exact_distance.hpp"
#include "planner/collision/own_shapes.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/local/parameters.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/whole_turns.hpp"

namespace hecaton::planner {
namespace {

/// Limit for joints without limits [rad]: larger angles lose precision within one turn.
constexpr double kFarthest = 1e4;

std::optional<Rejection> outside_limits(const Arm& arm, const JointVector& q) {
  for (int j = 0; j < arm.model->joints(); ++j) {
    const std::string& joint = arm.model->joint_names[j];
    std::ostringstream out;
    out << std::setprecision(8);  // shows an excess of kLimitRounding
    if (!std::isfinite(q[j])) {
      out << "joint " << joint << " = " << q[j] << " must be a finite number";
      return Rejection{RejectionKind::kMalformed, joint, out.str()};
    }
    const double lower = std::max(arm.limits.lower[j], -kFarthest);
    const double upper = std::min(arm.limits.upper[j], kFarthest);
    if (q[j] < lower || q[j] > upper) {
      out << "joint " << joint << " = " << q[j] << " must be within " << lower << " … " << upper;
      return Rejection{RejectionKind::kOutsideLimits, joint, out.str()};
    }
  }
  return std::nullopt;
}

constexpr int kMostTouching = 64;  ///< pairs of bodies that are looked at
/// A joint that moves the nearest points apart more slowly does not change their distance [m/rad | 1].
constexpr double kChangesNothing = 1e-6;

/// True if the bodies are apart, only a capsule around one of them touches, and no joint changes that. An example is
/// the capsule of a turning base, which reaches into the table below. Such a pair is no reason against a goal.
bool touches_by_capsule(const CellGeometry& geometry, const CellPoses& poses, const Clearance& clearance) {
  if (clearance.counterpart == Counterpart::kSelf) return false;
  JointVector row;
  directional_jacobian(*geometry.own_arm().model, *poses.own, clearance.own_link, clearance.p_own_W, clearance.n_W,
                       row);
  return row.cwiseAbs().maxCoeff() < kChangesNothing && distance_of_own_shapes(geometry, poses, clearance) > 0.0;
}

/// What the user can do about an overlap of the goal.
std::string remedy(const Clearance& pair, const std::string& other) {
  switch (pair.counterpart) {
    case Counterpart::kSelf:
      return "choose a posture that is folded less; if these links cannot touch, exclude the pair in the SRDF "
             "(disable_collisions)";
    case Counterpart::kArm:
      return "choose a goal clear of " + other + ", which stays where it is";
    case Counterpart::kObstacle:
      break;
  }
  return "choose a goal clear of " + other + ", or move or remove that obstacle";
}

constexpr double kDegree = std::numbers::pi / 180.0;
/// Share of a tolerance that a configuration may use; the rest is for the drive.
constexpr double kPlannedShare = 0.9;

std::string position_text(const Eigen::Vector3d& p) {
  std::ostringstream out;
  out << std::setprecision(3) << "(" << p.x() << ", " << p.y() << ", " << p.z() << ")";
  return out.str();
}

/// Roll, pitch, yaw [rad], without negative zeros.
std::string orientation_text(const Pose& pose) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(3);
  const Eigen::Vector3d rpy = world::rpy_of(pose.linear());
  for (int i = 0; i < 3; ++i) out << (i == 0 ? "" : " ") << std::round(rpy[i] * 1e3) / 1e3 + 0.0;
  return out.str();
}

std::string degrees_text(double radians) {
  std::ostringstream out;
  out << std::setprecision(3) << radians / kDegree << "°";
  return out.str();
}

std::string millimetres_text(double metres) {
  std::ostringstream out;
  out << std::setprecision(3) << metres * 1e3 << " mm";
  return out.str();
}

std::string error_text(const ToolError& error) {
  return millimetres_text(error.position) + " and " + degrees_text(error.orientation);
}

/// Solves one tool goal and counts what its solutions fail on.
class ToolGoalResolver {
 public:
  ToolGoalResolver(const Arm& arm, const ToolGoal& goal, const JointVector& q_now, const ConfigurationCheck& check,
                   const ConfigurationCheck& on_way)
      : arm_(arm), goal_(goal), q_now_(q_now), check_(check), on_way_(on_way ? on_way : check) {
    options_.free_rotation = goal.free_rotation;
    options_.position_tolerance = std::min(options_.position_tolerance, 0.1 * goal.position_tolerance);
    options_.orientation_tolerance = std::min(options_.orientation_tolerance, 0.1 * goal.orientation_tolerance);
    options_.accept = [this](const JointVector& q) {
      ++reaching_;
      failed_ = check_(q);
      return !failed_;
    };
  }

  ToolGoalAnswer resolve() {
    if (const ArmReach reach = arm_reach(arm_); away(reach) > reach.tool + goal_.position_tolerance) {
      std::ostringstream out;
      out << std::setprecision(3) << ": that is " << away(reach)
          << " m from its first joint, and it reaches no farther than " << reach.tool << " m";
      return rejected(RejectionKind::kUnreachable, arm_.name, out.str());
    }
    if (auto q = inverse_kinematics(arm_, goal_.X_WT, q_now_, options_)) return {.q = with_free_way(*q)};
    if (failed_) return in_collision();
    std::optional<NearestOrientation> nearest;
    if (goal_.free_rotation != FreeRotation::kAll) nearest = nearest_orientation(arm_, goal_.X_WT, q_now_, options_);
    if (nearest && nearest->angle <= kPlannedShare * goal_.orientation_tolerance)
      return {.q = with_free_way(nearest->q)};
    if (auto q = within_tolerances()) return {.q = with_free_way(*q)};
    if (nearest) {
      ToolGoalAnswer answer =
          rejected(RejectionKind::kOrientation, arm_.name,
                   " in that orientation: the nearest that it can take there is " + degrees_text(nearest->angle) +
                       " away, roll pitch yaw " + orientation_text(nearest->X_WT));
      answer.nearest = std::move(nearest);
      return answer;
    }
    if (failed_) return in_collision();
    return rejected(RejectionKind::kUnreachable, arm_.name,
                    " in any orientation: no joint positions within the limits were found, from " +
                        std::to_string(options_.seeds + 1) + " postures");
  }

 private:
  [[nodiscard]] double away(const ArmReach& reach) const { return (goal_.X_WT.translation() - reach.centre).norm(); }

  [[nodiscard]] JointVector with_free_way(const JointVector& q) const {
    return turns_with_free_way(arm_, q, q_now_, [this](const JointVector& between) { return !on_way_(between); });
  }

  std::optional<JointVector> within_tolerances() {
    IkOptions loose = options_;
    loose.position_tolerance = kPlannedShare * goal_.position_tolerance;
    loose.orientation_tolerance = kPlannedShare * goal_.orientation_tolerance;
    return inverse_kinematics(arm_, goal_.X_WT, q_now_, loose);
  }

  [[nodiscard]] ToolGoalAnswer rejected(RejectionKind kind, std::string subject, const std::string& why) const {
    const std::string where =
        "the tool of arm " + arm_.name + " cannot be at " + position_text(goal_.X_WT.translation());
    return {.q = {}, .rejection = Rejection{kind, std::move(subject), where + why}};
  }

  [[nodiscard]] ToolGoalAnswer in_collision() const {
    return rejected(
        failed_->kind, failed_->subject,
        ": none of " + std::to_string(reaching_) + " joint positions found there is free; the last: " + failed_->text);
  }

  const Arm& arm_;
  const ToolGoal& goal_;
  const JointVector& q_now_;
  const ConfigurationCheck& check_;
  const ConfigurationCheck& on_way_;
  IkOptions options_;
  int reaching_ = 0;                 ///< configurations that meet the goal, or its position
  std::optional<Rejection> failed_;  ///< of the last of them
};

}  // namespace

std::string clamp_rounding(const Arm& arm, JointVector& q) {
  std::ostringstream out;
  out << std::setprecision(12);
  if (q.size() != arm.model->joints()) return {};
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double inside = std::clamp(q[j], arm.limits.lower[j], arm.limits.upper[j]);
    if (inside == q[j] || !(std::abs(inside - q[j]) <= kLimitRounding)) continue;
    out << (out.tellp() > 0 ? ", " : "") << "joint " << arm.model->joint_names[static_cast<std::size_t>(j)] << " = "
        << q[j] << " is outside its limit by rounding and becomes " << inside;
    q[j] = inside;
  }
  return out.str();
}

ToolGoalAnswer resolve_tool_goal(const Arm& arm, const ToolGoal& goal, const JointVector& q_now,
                                 const ConfigurationCheck& check, const ConfigurationCheck& on_way) {
  return ToolGoalResolver(arm, goal, q_now, check, on_way).resolve();
}

std::optional<std::string> error_at_goal(const Arm& arm, const JointVector& q, const JointVector& q_goal,
                                         double tolerance, const ToolGoal* tool) {
  const JointVector off = joint_difference(arm.limits, q, q_goal).cwiseAbs();
  Eigen::Index worst = 0;
  if (off.size() > 0 && !(off.maxCoeff(&worst) <= tolerance)) {
    std::ostringstream out;
    out << std::setprecision(3) << "joint " << arm.model->joint_names[static_cast<std::size_t>(worst)] << " is "
        << off[worst] << " from its goal (tolerance " << tolerance << ")";
    return out.str();
  }
  if (tool == nullptr) return std::nullopt;
  Kinematics kinematics;
  forward_kinematics(*arm.model, arm.X_WB, q, kinematics);
  const ToolError error = tool_error(*tool, kinematics.X_WT);
  if (within_tolerance(*tool, error)) return std::nullopt;
  const auto text = [&](const ToolError& of) {
    return tool->free_rotation == FreeRotation::kAll ? millimetres_text(of.position) : error_text(of);
  };
  return "the tool is " + text(error) + " from its goal (tolerance " +
         text({tool->position_tolerance, tool->orientation_tolerance}) + ")";
}

std::optional<Rejection> reject_goal(const CellGeometry& geometry, const JointVector& q_goal,
                                     std::span<const world::ObstacleState> obstacles, double self_distance) {
  const Arm& arm = geometry.own_arm();
  std::ostringstream out;
  if (q_goal.size() != arm.model->joints()) {
    out << "goal has " << q_goal.size() << " joint values, arm " << arm.name << " has " << arm.model->joints()
        << " joints";
    return Rejection{RejectionKind::kMalformed, arm.name, out.str()};
  }
  if (auto rejection = outside_limits(arm, q_goal)) return rejection;

  // Other arms will move, but their bases stay.
  const CellGeometry lasting = geometry.without_moving_others();
  ExactDistance distance(lasting);
  std::vector<Kinematics> arms(lasting.arms().size());
  for (std::size_t i = 0; i < arms.size(); ++i) {
    const Arm& other = lasting.arms()[i];
    forward_kinematics(*other.model, other.X_WB, JointVector::Zero(other.model->joints()), arms[i]);
  }
  Kinematics own;
  forward_kinematics(*arm.model, arm.X_WB, q_goal, own);
  const CellPoses poses{&own, arms, obstacles};
  std::vector<Clearance> near(kMostTouching);
  near.resize(static_cast<std::size_t>(
      distance.clearances(poses, {.others = 0.0, .self = self_distance, .self_share = kSecurityShare}, near)));
  std::erase_if(near, [&](const Clearance& pair) { return touches_by_capsule(lasting, poses, pair); });
  if (near.empty()) return std::nullopt;
  const Clearance& deepest = *std::min_element(
      near.begin(), near.end(), [](const Clearance& a, const Clearance& b) { return a.distance < b.distance; });
  const std::string other = lasting.other_name(deepest);
  out << "goal is in collision: " << lasting.own_name(deepest) << " and " << other;
  if (deepest.distance > 0.0) {
    out << " are " << deepest.distance * 1000.0 << " mm apart";
  } else {
    out << " overlap by " << -deepest.distance * 1000.0 << " mm";
  }
  const bool self = deepest.counterpart == Counterpart::kSelf;
  const double least =
      self ? std::min(self_distance, kSecurityShare * lasting.widest(deepest.own_body, deepest.other_body)) : 0.0;
  out << " (minimum distance " << least * 1000.0 << " mm); " << remedy(deepest, other);
  return Rejection{RejectionKind::kInCollision, other, out.str()};
}

}  // namespace hecaton::planner
