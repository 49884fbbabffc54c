#include <cmath>
#include <numbers>

#include "planner/model/inverse_kinematics.hpp"
#include "services/config/findings.hpp"
#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

// The centre and two rings of eight, at three heights; in W, for an arm with its base at X_WB.
std::vector<Eigen::Vector3d> sample_points(const planner::TaskArea& area, const planner::Pose& X_WB) {
  const planner::Pose X_WA = area.frame(X_WB);
  std::vector<Eigen::Vector3d> points;
  for (const double height : {-area.half_height, 0.0, area.half_height}) {
    const Eigen::Vector3d middle = area.centre + Eigen::Vector3d(0.0, 0.0, height);
    points.push_back(X_WA * middle);
    for (const double radius : {0.5 * area.radius, area.radius}) {
      for (int k = 0; k < 8; ++k) {
        const double angle = std::numbers::pi / 4.0 * k;
        points.push_back(X_WA * (middle + radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0)));
      }
    }
  }
  return points;
}

bool reaches(const planner::Arm& arm, const Eigen::Vector3d& p_W) {
  planner::IkOptions options;
  options.task = planner::IkTask::kPosition;
  options.seeds = 24;
  options.iterations = 100;
  options.position_tolerance = 1e-3;
  planner::Pose X_WT = planner::Pose::Identity();
  X_WT.translation() = p_W;
  return planner::inverse_kinematics(arm, X_WT, arm.home(), options).has_value();
}

}  // namespace

void check_reach(const planner::Cell& cell, Findings& findings) {
  if (!cell.tasks.pose_sequence.empty() || !cell.tasks.problem.areas.empty()) return;
  if (cell.tasks.radius <= 0.0) {
    findings.push_back({Severity::kNote, "tasks is missing: no random goals can be drawn in this cell"});
    return;
  }
  for (int arm = 0; arm < static_cast<int>(cell.arms.size()); ++arm) {
    const auto points = sample_points(cell.tasks, cell.arms[arm].arm.X_WB);
    std::size_t reached = 0;
    for (const Eigen::Vector3d& point : points) reached += reaches(cell.arms[arm].arm, point) ? 1U : 0U;
    if (reached == points.size()) continue;
    const std::string who = "tasks: " + arm_key(arm) + " (" + cell.arms[arm].arm.name + ") reaches ";
    if (reached == 0) {
      findings.push_back({Severity::kError, who + "no part of the task area"});
      continue;
    }
    const std::string share = std::to_string(reached) + " of " + std::to_string(points.size());
    findings.push_back({2 * reached < points.size() ? Severity::kWarning : Severity::kNote,
                        who + share + " sample points of the task area"});
  }
}

}  // namespace hecaton::config
