#include "planner/global/timed_path.hpp"

#include <algorithm>

namespace hecaton::planner::global {
namespace {

std::vector<float> floats_of(const Validity& validity, const Eigen::VectorXd& q) {
  std::vector<float> result(validity.stride(), 0.0F);
  std::transform(q.begin(), q.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

}  // namespace

MotionLimits motion_limits(const Validity& validity) {
  MotionLimits all{Eigen::VectorXd(validity.dimensions()), Eigen::VectorXd(validity.dimensions())};
  Eigen::Index first = 0;
  for (const CellGeometry& geometry : validity.planned()) {
    const JointLimits& limits = geometry.own_arm().limits;
    all.velocity.segment(first, limits.velocity.size()) = limits.velocity;
    all.acceleration.segment(first, limits.acceleration.size()) = limits.acceleration;
    first += limits.velocity.size();
  }
  return all;
}

Trajectory timed_path(const Validity& validity, const std::vector<std::vector<double>>& path,
                      const TimedPathOptions& options) {
  std::vector<Eigen::VectorXd> waypoints;
  for (const std::vector<double>& q : path) {
    waypoints.emplace_back(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
  }
  const CurveFree free = [&](const Eigen::VectorXd& from, const Eigen::VectorXd& corner, const Eigen::VectorXd& to) {
    return validity.proven_free(floats_of(validity, from).data(), floats_of(validity, corner).data(),
                                floats_of(validity, to).data(), options.clearance);
  };
  return time_optimal(blended(waypoints, free, options.blend), motion_limits(validity), options.timing);
}

}  // namespace hecaton::planner::global
