#include "planner/trajectory/blended_path.hpp"

#include <algorithm>

namespace hecaton::planner {
namespace {

/// Directions and points that differ by less count as equal [rad | m].
constexpr double kSame = 1e-9;

struct Polyline {
  std::vector<Eigen::VectorXd> corners;
  std::vector<Eigen::VectorXd> directions;  ///< unit, from corner i to the next
  std::vector<double> lengths;
};

Polyline polyline_of(const std::vector<Eigen::VectorXd>& waypoints) {
  Polyline line;
  for (const Eigen::VectorXd& q : waypoints) {
    if (line.corners.empty()) {
      line.corners.push_back(q);
      continue;
    }
    const Eigen::VectorXd way = q - line.corners.back();
    const double length = way.norm();
    if (length <= kSame) continue;
    const Eigen::VectorXd direction = way / length;
    if (!line.directions.empty() && (direction - line.directions.back()).norm() <= kSame) {
      line.lengths.back() += length;
      line.corners.back() = q;
      continue;
    }
    line.corners.push_back(q);
    line.directions.push_back(direction);
    line.lengths.push_back(length);
  }
  // The last waypoint may have been dropped.
  if (line.corners.size() > 1) line.corners.back() = waypoints.back();
  return line;
}

/// Length that the blend at corner i takes from the lines before and behind it; 0: no blend.
double blend_reach(const Polyline& line, std::size_t i, const CurveFree& free, const BlendOptions& options) {
  const Eigen::VectorXd& before = line.directions[i - 1];
  const Eigen::VectorXd& behind = line.directions[i];
  const double share_before = i == 1 ? 1.0 : 0.5;
  const double share_behind = i + 1 == line.directions.size() ? 1.0 : 0.5;
  double reach = std::min({share_before * line.lengths[i - 1], share_behind * line.lengths[i],
                           4.0 * options.deviation / (behind - before).norm()});
  for (int k = 0; k <= options.halvings && reach > kSame; ++k, reach *= 0.5) {
    const Eigen::VectorXd& corner = line.corners[i];
    if (free(corner - reach * before, corner, corner + reach * behind)) return reach;
  }
  return 0.0;
}

}  // namespace

std::vector<PathPiece> blended(const std::vector<Eigen::VectorXd>& waypoints, const CurveFree& free,
                               const BlendOptions& options) {
  std::vector<PathPiece> pieces;
  const Polyline line = polyline_of(waypoints);
  double taken = 0.0;  // length of this line inside the previous blend
  for (std::size_t i = 0; i < line.directions.size(); ++i) {
    const Eigen::VectorXd& u = line.directions[i];
    const bool last = i + 1 == line.directions.size();
    const double reach = last ? 0.0 : blend_reach(line, i + 1, free, options);
    const double straight = line.lengths[i] - taken - reach;
    const Eigen::VectorXd zero = Eigen::VectorXd::Zero(u.size());
    if (straight > kSame)
      pieces.push_back({line.corners[i] + taken * u, u, zero, straight, false, !last && reach <= 0.0});
    if (reach > 0.0) {
      const Eigen::VectorXd bend = (line.directions[i + 1] - u) / (2.0 * reach);
      pieces.push_back({line.corners[i + 1] - reach * u, u, bend, 2.0 * reach, true, false});
    }
    taken = reach;
  }
  return pieces;
}

}  // namespace hecaton::planner
