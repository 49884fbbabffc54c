#include "planner/trajectory/timed_trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

namespace hecaton::planner {
namespace {

/// A velocity at the end below this counts as rest [rad/s | m/s].
constexpr double kRest = 1e-3;

bool finite(const JointVector& values) {
  return values.allFinite();
}

}  // namespace

JointState interpolate(const TimedPoint& from, const TimedPoint& to, double time) {
  const double T = to.time - from.time;
  const double t = std::clamp(time - from.time, 0.0, T);
  const JointVector way = to.q - from.q;
  if (from.qd.size() == 0 || to.qd.size() == 0) return {from.q + (t / T) * way, way / T};
  const double T2 = T * T;
  if (from.qdd.size() == 0 || to.qdd.size() == 0) {
    const JointVector c2 = (3.0 * way - (2.0 * from.qd + to.qd) * T) / T2;
    const JointVector c3 = (-2.0 * way + (from.qd + to.qd) * T) / (T2 * T);
    return {from.q + t * (from.qd + t * (c2 + t * c3)), from.qd + t * (2.0 * c2 + 3.0 * t * c3)};
  }
  const JointVector c2 = 0.5 * from.qdd;
  const JointVector c3 =
      (20.0 * way - (8.0 * to.qd + 12.0 * from.qd) * T - (3.0 * from.qdd - to.qdd) * T2) / (2.0 * T2 * T);
  const JointVector c4 =
      (-30.0 * way + (14.0 * to.qd + 16.0 * from.qd) * T + (3.0 * from.qdd - 2.0 * to.qdd) * T2) / (2.0 * T2 * T2);
  const JointVector c5 = (12.0 * way - 6.0 * (to.qd + from.qd) * T + (to.qdd - from.qdd) * T2) / (2.0 * T2 * T2 * T);
  return {from.q + t * (from.qd + t * (c2 + t * (c3 + t * (c4 + t * c5)))),
          from.qd + t * (2.0 * c2 + t * (3.0 * c3 + t * (4.0 * c4 + 5.0 * t * c5)))};
}

std::size_t TimedTrajectory::next_point(double time) const {
  const auto after = std::upper_bound(points.begin(), points.end(), time,
                                      [](double value, const TimedPoint& point) { return value < point.time; });
  return static_cast<std::size_t>(after - points.begin());
}

bool TimedTrajectory::has_path_tolerance() const {
  return std::any_of(path_tolerance.begin(), path_tolerance.end(), [](double value) { return std::isfinite(value); });
}

JointState TimedTrajectory::at(double time) const {
  if (time < points.front().time || time >= duration()) {
    const JointVector& q = time >= duration() ? points.back().q : points.front().q;
    return {q, JointVector::Zero(q.size())};
  }
  const std::size_t after = next_point(time);
  return interpolate(points[after - 1], points[after], time);
}

std::optional<std::string> objection(const TimedTrajectory& trajectory, const JointLimits& limits,
                                     const std::vector<std::string>& joint_names) {
  std::ostringstream out;
  out << std::setprecision(6) << "trajectory: ";
  const Eigen::Index joints = limits.lower.size();
  if (trajectory.points.empty() || trajectory.points.size() > TimedTrajectory::kMostPoints) {
    out << trajectory.points.size() << " points must be from 1 to " << TimedTrajectory::kMostPoints;
    return out.str();
  }
  double before = -1.0;
  for (std::size_t i = 0; i < trajectory.points.size(); ++i) {
    const TimedPoint& point = trajectory.points[i];
    const auto fits = [&](const JointVector& values, bool optional) {
      return (optional && values.size() == 0) || (values.size() == joints && finite(values));
    };
    if (!fits(point.q, false) || !fits(point.qd, true) || !fits(point.qdd, true)) {
      out << "point " << i << " must have " << joints << " finite numbers of each kind";
      return out.str();
    }
    if (!std::isfinite(point.time) || point.time < 0.0 || point.time <= before) {
      out << "the time of point " << i << " = " << point.time << " s must be "
          << (i == 0 ? "0 or above" : "above that of the point before");
      return out.str();
    }
    before = point.time;
    for (Eigen::Index j = 0; j < joints; ++j) {
      if (point.q[j] >= limits.lower[j] - kLimitRounding && point.q[j] <= limits.upper[j] + kLimitRounding) continue;
      out << "joint " << joint_names[static_cast<std::size_t>(j)] << " = " << point.q[j] << " of point " << i
          << " must be within " << limits.lower[j] << " … " << limits.upper[j];
      return out.str();
    }
  }
  const TimedPoint& last = trajectory.points.back();
  if (last.qd.size() > 0 && last.qd.cwiseAbs().maxCoeff() > kRest) {
    out << "the last point must have velocity 0, not " << last.qd.cwiseAbs().maxCoeff();
    return out.str();
  }
  const JointVector& tolerance = trajectory.path_tolerance;
  const bool fits = tolerance.size() == 0 || tolerance.size() == joints;
  if (!fits || std::any_of(tolerance.begin(), tolerance.end(), [](double value) { return !(value > 0.0); })) {
    out << "path_tolerance must have " << joints << " numbers above 0";
    return out.str();
  }
  return std::nullopt;
}

}  // namespace hecaton::planner
