#include "services/planner/motion_report.hpp"

#include <algorithm>

namespace hecaton::services {
namespace {

static_assert(planner::kMostRolloutPoints <= MotionReport::kMostPoints);

/// All joints of all points. Of too many points it leaves out some, but never the last one.
void write(const std::vector<planner::JointVector>& points, std::vector<double>& values) {
  values.clear();
  const std::size_t every = (points.size() + MotionReport::kMostPoints - 1) / MotionReport::kMostPoints;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool taken = (points.size() - 1 - i) % every == 0;
    if (taken) values.insert(values.end(), points[i].begin(), points[i].end());
  }
}

}  // namespace

MotionReport::MotionReport(const std::string& arm, const std::string& node) {
  message_.arm(arm);
  message_.node(node);
  message_.foreseen_period(planner::kRolloutPathStep);
}

bool MotionReport::update(double time, const planner::ArmPlanner& planner, const planner::RolloutAnswer* answer) {
  if (answer != nullptr) {
    write(answer->path, foreseen_);
    over_at_ = time + planner::kRolloutPathStep * static_cast<double>(answer->path.size());
  }
  if (!begins_ && time < due_at_) return false;
  if (time >= over_at_) foreseen_.clear();
  write(planner.way(), way_);
  if (!begins_ && way_ == message_.way() && foreseen_ == message_.foreseen()) return false;
  begins_ = false;
  due_at_ = time + kPeriod;
  message_.way(way_);
  message_.foreseen(foreseen_);
  return true;
}

}  // namespace hecaton::services
