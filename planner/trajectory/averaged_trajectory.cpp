#include "planner/trajectory/averaged_trajectory.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::planner {

AveragedTrajectory::AveragedTrajectory(Trajectory trajectory, double window)
    : of_(std::move(trajectory)), window_(of_.pieces().empty() ? 0.0 : window) {
  if (window_ <= 0.0) return;
  const auto& phases = of_.phases();
  before_.emplace_back(Eigen::VectorXd::Zero(of_.pieces().front().q.size()));
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const double ends = i + 1 < phases.size() ? phases[i + 1].begins : of_.duration();
    before_.emplace_back(before_.back() + within(phases[i], ends - phases[i].begins));
  }
}

/// ∫ (q − q(0)) over the first dt of the phase: q is a square in s, and s one in time.
Eigen::VectorXd AveragedTrajectory::within(const Trajectory::Phase& phase, double dt) const {
  const PathPiece& piece = of_.pieces()[phase.piece];
  const double s = phase.s, v = phase.sd, u = phase.sdd;
  const double once = dt * (s + dt * (v / 2.0 + dt * u / 6.0));
  const double squared =
      dt * (s * s + dt * (s * v + dt * ((v * v + s * u) / 3.0 + dt * (v * u / 4.0 + dt * u * u / 20.0))));
  return dt * (piece.q - of_.pieces().front().q) + once * piece.d + 0.5 * squared * piece.c;
}

Eigen::VectorXd AveragedTrajectory::integral(double t) const {
  if (t <= 0.0) return before_.front();
  if (t >= of_.duration()) {
    return before_.back() + (t - of_.duration()) * (of_.at(of_.duration()).q - of_.pieces().front().q);
  }
  const auto& phases = of_.phases();
  const auto behind = std::upper_bound(phases.begin(), phases.end(), t,
                                       [](double time, const Trajectory::Phase& phase) { return time < phase.begins; });
  const auto index = static_cast<std::size_t>(behind - phases.begin()) - 1;
  return before_[index] + within(phases[index], t - phases[index].begins);
}

TrajectoryPoint AveragedTrajectory::at(double t) const {
  if (window_ <= 0.0 || t <= 0.0 || t >= duration()) return of_.at(t);
  const TrajectoryPoint now = of_.at(t);
  const TrajectoryPoint then = of_.at(t - window_);
  return {of_.pieces().front().q + (integral(t) - integral(t - window_)) / window_, (now.q - then.q) / window_,
          (now.qd - then.qd) / window_};
}

}  // namespace hecaton::planner
