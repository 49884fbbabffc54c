#include "planner/trajectory/jerk_limited.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
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

/// ∫ (q − q(0)) over the first dt of the phase: q is quadratic in s, and s is quadratic in time.
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

namespace {

/// Factor between the acceleration limits that are tried one after the other.
constexpr double kGentler = 0.8;
constexpr int kMostShares = 40;
/// Largest deviation of the trajectory from the chords that are checked instead, per joint [rad | m].
constexpr double kChordDepth = 1e-4;
/// Rounding errors of proofs in float [rad | m].
constexpr double kRounded = 2e-6;
/// A refused blend may be tried again below this share of its length.
constexpr double kShorter = 0.75;
/// Corners nearer to each other count as equal [rad | m].
constexpr double kSameCorner = 1e-6;

/// A blend that leaves free space after averaging.
struct Refused {
  Eigen::VectorXd corner;
  double reach;
};

/// A blend, and the time span in which the window covers a part of it.
struct Seen {
  int piece;
  double from;
  double to;
};

/// The largest |q̈| of any joint: it is linear in time on lines and in s on blends.
double peak_acceleration(const Trajectory& trajectory) {
  double peak = 0.0;
  const auto& phases = trajectory.phases();
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const Trajectory::Phase& phase = phases[i];
    const PathPiece& piece = trajectory.pieces()[phase.piece];
    const double dt = (i + 1 < phases.size() ? phases[i + 1].begins : trajectory.duration()) - phase.begins;
    const double s = phase.s + dt * (phase.sd + 0.5 * dt * phase.sdd);
    const double sd = phase.sd + dt * phase.sdd;
    const auto at = [&](double where, double speed) {
      return (piece.slope(where) * phase.sdd + piece.c * (speed * speed)).cwiseAbs().maxCoeff();
    };
    peak = std::max({peak, at(phase.s, phase.sd), at(s, sd)});
  }
  return peak;
}

/// Extends every intermediate stop by `window`.
Trajectory with_pauses(const Trajectory& trajectory, double window) {
  std::vector<Trajectory::Phase> phases;
  double later = 0.0;
  for (const Trajectory::Phase& phase : trajectory.phases()) {
    const int before = phases.empty() ? phase.piece : phases.back().piece;
    if (before != phase.piece && trajectory.pieces()[before].stop_behind) {
      phases.push_back({before, trajectory.pieces()[before].length, 0.0, 0.0, phase.begins + later});
      later += window;
    }
    phases.push_back(phase);
    phases.back().begins += later;
  }
  return {trajectory.pieces(), std::move(phases), trajectory.duration() + later};
}

AveragedTrajectory averaged(const std::vector<PathPiece>& pieces, const MotionLimits& limits,
                            const JerkOptions& options) {
  const Trajectory trajectory = time_optimal(pieces, limits, options.timing);
  const double window = 2.0 * peak_acceleration(trajectory) / options.jerk;
  return AveragedTrajectory(with_pauses(trajectory, window), window);
}

/// The fastest result over all shares of the acceleration limits.
AveragedTrajectory fastest(const std::vector<PathPiece>& pieces, MotionLimits limits, const JerkOptions& options) {
  AveragedTrajectory best = averaged(pieces, limits, options);
  for (int i = 1; i < kMostShares; ++i) {
    limits.acceleration *= kGentler;
    AveragedTrajectory gentler = averaged(pieces, limits, options);
    if (gentler.duration() >= best.duration()) break;
    best = std::move(gentler);
  }
  return best;
}

std::vector<Seen> blends_seen(const AveragedTrajectory& trajectory) {
  std::vector<Seen> seen;
  const Trajectory& of = trajectory.averaged();
  for (std::size_t i = 0; i < of.phases().size(); ++i) {
    const Trajectory::Phase& phase = of.phases()[i];
    if (!of.pieces()[phase.piece].blend) continue;
    const double ends = i + 1 < of.phases().size() ? of.phases()[i + 1].begins : of.duration();
    if (seen.empty() || seen.back().piece != phase.piece) seen.push_back({phase.piece, phase.begins, 0.0});
    seen.back().to = ends + trajectory.window();
  }
  return seen;
}

double distance_to(const std::vector<Eigen::VectorXd>& line, const Eigen::VectorXd& q) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    const Eigen::VectorXd way = line[i + 1] - line[i];
    const double along = way.squaredNorm() > 0.0 ? std::clamp(way.dot(q - line[i]) / way.squaredNorm(), 0.0, 1.0) : 0.0;
    least = std::min(least, (q - line[i] - along * way).norm());
  }
  return least;
}

class Search {
 public:
  Search(const std::vector<Eigen::VectorXd>& waypoints, const CurveFree& curve_free, const SegmentFree& segment_free,
         const MotionLimits& limits, const JerkOptions& options)
      : waypoints_(waypoints),
        curve_free_(curve_free),
        segment_free_(segment_free),
        limits_(limits),
        options_(options),
        step_(std::sqrt(8.0 * kChordDepth / limits.acceleration.maxCoeff())),
        spread_(limits.acceleration * (step_ * step_ / 8.0) +
                Eigen::VectorXd::Constant(limits.acceleration.size(), kRounded)) {}

  /// Each iteration refuses a blend, which can only return shorter. So the loop ends, at last without any blend.
  AveragedTrajectory run() {
    const CurveFree not_refused = [this](const Eigen::VectorXd& from, const Eigen::VectorXd& corner,
                                         const Eigen::VectorXd& to) {
      const double reach = (corner - from).norm();
      const bool refused = std::any_of(refused_.begin(), refused_.end(), [&](const Refused& one) {
        return reach > kShorter * one.reach && (one.corner - corner).norm() <= kSameCorner;
      });
      return !refused && curve_free_(from, corner, to);
    };
    while (true) {
      const std::vector<PathPiece> pieces = blended(waypoints_, not_refused, options_.blend);
      if (pieces.empty()) return {};
      AveragedTrajectory trajectory = fastest(pieces, limits_, options_);
      if (!refuse_some(trajectory)) return trajectory;
    }
  }

 private:
  /// Checks the parts of the trajectory that leave the path, and refuses the blends of the parts that are not free.
  /// Returns false if all parts are free.
  bool refuse_some(const AveragedTrajectory& trajectory) {
    const std::size_t before = refused_.size();
    const std::vector<Seen> seen = blends_seen(trajectory);
    for (std::size_t first = 0; first < seen.size();) {
      double to = seen[first].to;
      std::size_t behind = first + 1;
      for (; behind < seen.size() && seen[behind].from <= to; ++behind) to = std::max(to, seen[behind].to);
      refuse_within(
          trajectory,
          {seen.begin() + static_cast<std::ptrdiff_t>(first), seen.begin() + static_cast<std::ptrdiff_t>(behind)},
          seen[first].from, to);
      first = behind;
    }
    return refused_.size() > before;
  }

  void refuse_within(const AveragedTrajectory& trajectory, const std::vector<Seen>& seen, double from, double to) {
    std::vector<bool> refused(seen.size(), false);
    const int chords = std::max(1, static_cast<int>(std::ceil((to - from) / step_)));
    Eigen::VectorXd begins = trajectory.at(from).q;
    for (int k = 0; k < chords; ++k) {
      const double t = from + (to - from) * k / chords;
      const double t_end = from + (to - from) * (k + 1) / chords;
      const Eigen::VectorXd ends = trajectory.at(t_end).q;
      const auto sees = [&](std::size_t i) { return seen[i].from < t_end && t < seen[i].to; };
      bool looked_at = true;  // unless a covered blend is already refused
      for (std::size_t i = 0; i < seen.size(); ++i) looked_at = looked_at && !(sees(i) && refused[i]);
      if (looked_at && !allowed(begins, ends)) {
        for (std::size_t i = 0; i < seen.size(); ++i) refused[i] = refused[i] || sees(i);
      }
      begins = ends;
    }
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!refused[i]) continue;
      const PathPiece& blend = trajectory.averaged().pieces()[seen[i].piece];
      refused_.push_back({blend.at(0.0) + 0.5 * blend.length * blend.d, 0.5 * blend.length});
    }
  }

  [[nodiscard]] bool allowed(const Eigen::VectorXd& from, const Eigen::VectorXd& to) const {
    return distance_to(waypoints_, to) <= options_.blend.deviation && segment_free_(from, to, spread_);
  }

  const std::vector<Eigen::VectorXd>& waypoints_;
  const CurveFree& curve_free_;
  const SegmentFree& segment_free_;
  const MotionLimits& limits_;
  const JerkOptions& options_;
  double step_;             ///< of chords [s]
  Eigen::VectorXd spread_;  ///< around chords
  std::vector<Refused> refused_;
};

}  // namespace

AveragedTrajectory jerk_limited(const std::vector<Eigen::VectorXd>& waypoints, const CurveFree& curve_free,
                                const SegmentFree& segment_free, const MotionLimits& limits,
                                const JerkOptions& options) {
  return Search(waypoints, curve_free, segment_free, limits, options).run();
}

}  // namespace hecaton::planner
