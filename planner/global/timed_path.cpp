#include "planner/global/timed_path.hpp"

#include <algorithm>

namespace hecaton::planner::global {
namespace {

std::vector<float> floats_of(const Validity& validity, const Eigen::VectorXd& q) {
  std::vector<float> result(validity.stride(), 0.0F);
  std::transform(q.begin(), q.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

std::vector<Eigen::VectorXd> waypoints_of(const std::vector<std::vector<double>>& path) {
  std::vector<Eigen::VectorXd> waypoints;
  for (const std::vector<double>& q : path) {
    waypoints.emplace_back(Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
  }
  return waypoints;
}

CurveFree proven_curve(const Validity& validity, double clearance) {
  return [&validity, clearance](const Eigen::VectorXd& from, const Eigen::VectorXd& corner, const Eigen::VectorXd& to) {
    return validity.curve_free(floats_of(validity, from).data(), floats_of(validity, corner).data(),
                               floats_of(validity, to).data(), clearance);
  };
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
  const CurveFree free = proven_curve(validity, options.clearance);
  return time_optimal(blended(waypoints_of(path), free, options.blend), motion_limits(validity), options.timing);
}

AveragedTrajectory jerk_limited_path(const Validity& validity, const std::vector<std::vector<double>>& path,
                                     double jerk, const TimedPathOptions& options) {
  const SegmentFree segment_free = [&](const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                                       const Eigen::VectorXd& spread) {
    const Eigen::VectorXd middle = 0.5 * (from + to);
    return validity.curve_free(floats_of(validity, from).data(), floats_of(validity, middle).data(),
                               floats_of(validity, to).data(), options.clearance, floats_of(validity, spread).data());
  };
  return jerk_limited(waypoints_of(path), proven_curve(validity, options.clearance), segment_free,
                      motion_limits(validity), {jerk, options.blend, options.timing});
}

}  // namespace hecaton::planner::global
