#include "planner/trajectory/time_optimal.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hecaton::planner {

// q̈ at the beginning: q′ u + q″ x = (q″ − q′/2h) x + q′/2h y; at the end: −q′/2h x + (q″ + q′/2h) y.
IntervalProgramme::IntervalProgramme(const Eigen::VectorXd& slope_begin, const Eigen::VectorXd& slope_end,
                                     const Eigen::VectorXd& bend, double h, const Eigen::VectorXd& acceleration)
    : strips_(2 * bend.size(), 3) {
  const Eigen::Index n = bend.size();
  const Eigen::VectorXd begin = slope_begin / (2.0 * h);
  const Eigen::VectorXd end = slope_end / (2.0 * h);
  strips_.topRows(n) << bend - begin, begin, acceleration;
  strips_.bottomRows(n) << -end, bend + end, acceleration;
}

IntervalProgramme::Bound IntervalProgramme::upper(double x, double most_y) const {
  Bound least{most_y, 0.0};
  for (Eigen::Index i = 0; i < strips_.rows(); ++i) {
    const double a = strips_(i, 0), b = strips_(i, 1), w = strips_(i, 2);
    if (b == 0.0) continue;
    const double value = std::copysign(w / b, 1.0) - a / b * x;
    if (value < least.value) least = {value, -a / b};
  }
  return least;
}

IntervalProgramme::Bound IntervalProgramme::lower(double x) const {
  Bound most{0.0, 0.0};
  for (Eigen::Index i = 0; i < strips_.rows(); ++i) {
    const double a = strips_(i, 0), b = strips_(i, 1), w = strips_(i, 2);
    if (b == 0.0) continue;
    const double value = -std::copysign(w / b, 1.0) - a / b * x;
    if (value > most.value) most = {value, -a / b};
  }
  return most;
}

// lower − upper is convex in x and ≤ 0 at x = 0: Newton steps from the right end at its largest root.
double IntervalProgramme::largest_begin(double most_x, double most_y) const {
  double x = most_x;
  for (Eigen::Index i = 0; i < strips_.rows(); ++i) {
    if (strips_(i, 1) == 0.0 && strips_(i, 0) != 0.0) x = std::min(x, strips_(i, 2) / std::abs(strips_(i, 0)));
  }
  for (int step = 0; step < 64; ++step) {
    const Bound low = lower(x);
    const Bound high = upper(x, most_y);
    const double excess = low.value - high.value;
    const double slope = low.slope - high.slope;
    if (excess <= 0.0 || slope <= 0.0) return x;
    const double next = std::max(0.0, x - excess / slope);
    if (next >= x) return x;
    x = next;
  }
  return 0.0;
}

double IntervalProgramme::largest_end(double x, double most_y) const {
  return std::max(0.0, upper(x, most_y).value);
}

namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// A line, or an interval of a blend's grid.
struct Stretch {
  int piece;
  double s;
  double length;
};

class Passes {
 public:
  Passes(const std::vector<PathPiece>& pieces, const MotionLimits& limits, const TimingOptions& options)
      : pieces_(pieces), limits_(limits) {
    for (int i = 0; i < static_cast<int>(pieces.size()); ++i) {
      const int count = pieces[i].blend ? options.intervals : 1;
      for (int k = 0; k < count; ++k) stretches_.push_back({i, k * pieces[i].length / count, pieces[i].length / count});
    }
    bound_velocities();
    backwards();
    forwards();
  }

  [[nodiscard]] std::vector<Trajectory::Phase> phases(double& duration) const {
    std::vector<Trajectory::Phase> phases;
    double t = 0.0;
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const Stretch& stretch = stretches_[i];
      if (!pieces_[stretch.piece].blend) {
        add_trapezoid(i, phases, t);
      } else {
        add_phase(stretch, 0.0, stretch.length, x_[i], x_[i + 1], phases, t);
      }
    }
    duration = t;
    return phases;
  }

 private:
  /// min of limit over |direction|.
  static double least_ratio(const Eigen::VectorXd& limit, const Eigen::VectorXd& direction) {
    double least = kUnlimited;
    for (Eigen::Index j = 0; j < limit.size(); ++j) {
      if (direction[j] != 0.0) least = std::min(least, limit[j] / std::abs(direction[j]));
    }
    return least;
  }
  [[nodiscard]] Eigen::VectorXd slope_before(const Stretch& at) const { return pieces_[at.piece].slope(at.s); }
  [[nodiscard]] Eigen::VectorXd slope_behind(const Stretch& at) const {
    return pieces_[at.piece].slope(at.s + at.length);
  }
  /// Of x on a line [1/s²].
  [[nodiscard]] double fastest_on(const PathPiece& line) const {
    const double v = least_ratio(limits_.velocity, line.d);
    return v * v;
  }

  // |q′ⱼ| and x are linear in an interval: their larger end values bound the product in the whole interval.
  void bound_velocities() {
    most_.assign(stretches_.size() + 1, kUnlimited);
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const Eigen::VectorXd steepest =
          slope_before(stretches_[i]).cwiseAbs().cwiseMax(slope_behind(stretches_[i]).cwiseAbs());
      const double v = least_ratio(limits_.velocity, steepest);
      most_[i] = std::min(most_[i], v * v);
      most_[i + 1] = v * v;
      const bool ends = i + 1 == stretches_.size() || stretches_[i + 1].piece != stretches_[i].piece;
      if (ends && pieces_[stretches_[i].piece].stop_behind) {
        most_[i + 1] = 0.0;
      }
    }
    most_.front() = most_.back() = 0.0;
  }

  [[nodiscard]] IntervalProgramme programme(std::size_t i) const {
    const Stretch& stretch = stretches_[i];
    return {slope_before(stretch), slope_behind(stretch), pieces_[stretch.piece].c, stretch.length,
            limits_.acceleration};
  }

  void backwards() {
    for (std::size_t i = stretches_.size(); i-- > 0;) {
      const Stretch& stretch = stretches_[i];
      const PathPiece& piece = pieces_[stretch.piece];
      const double within = piece.blend
                                ? programme(i).largest_begin(most_[i], most_[i + 1])
                                : most_[i + 1] + 2.0 * least_ratio(limits_.acceleration, piece.d) * piece.length;
      most_[i] = std::min(most_[i], within);
    }
  }

  void forwards() {
    x_.assign(stretches_.size() + 1, 0.0);
    for (std::size_t i = 0; i < stretches_.size(); ++i) {
      const PathPiece& piece = pieces_[stretches_[i].piece];
      x_[i + 1] = piece.blend
                      ? programme(i).largest_end(x_[i], most_[i + 1])
                      : std::min(most_[i + 1], x_[i] + 2.0 * least_ratio(limits_.acceleration, piece.d) * piece.length);
    }
  }

  static void add_phase(const Stretch& stretch, double from, double to, double x, double x_end,
                        std::vector<Trajectory::Phase>& phases, double& t) {
    const double length = to - from;
    if (length <= 0.0) return;
    phases.push_back({stretch.piece, stretch.s + from, std::sqrt(x), (x_end - x) / (2.0 * length), t});
    t += 2.0 * length / (std::sqrt(x) + std::sqrt(x_end));
  }

  /// Accelerates to the peak, keeps it, decelerates.
  void add_trapezoid(std::size_t i, std::vector<Trajectory::Phase>& phases, double& t) const {
    const Stretch& stretch = stretches_[i];
    const PathPiece& line = pieces_[stretch.piece];
    const double a = least_ratio(limits_.acceleration, line.d);
    const double x = x_[i];
    const double x_end = x_[i + 1];
    const double peak = std::max({x, x_end, std::min(fastest_on(line), 0.5 * (x + x_end) + a * line.length)});
    const double faster = std::min(line.length, (peak - x) / (2.0 * a));
    const double slower = std::max(faster, line.length - (peak - x_end) / (2.0 * a));
    add_phase(stretch, 0.0, faster, x, peak, phases, t);
    add_phase(stretch, faster, slower, peak, peak, phases, t);
    add_phase(stretch, slower, line.length, peak, x_end, phases, t);
  }

  const std::vector<PathPiece>& pieces_;
  const MotionLimits& limits_;
  std::vector<Stretch> stretches_;
  std::vector<double> most_;  ///< bounds of x at the ends of stretches; after backwards(): the end is reachable
  std::vector<double> x_;
};

}  // namespace

TrajectoryPoint Trajectory::at(double t) const {
  const Eigen::Index n = pieces_.front().q.size();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n);
  if (t <= 0.0) return {pieces_.front().q, rest, rest};
  if (t >= duration_) return {pieces_.back().at(pieces_.back().length), rest, rest};
  const auto behind = std::upper_bound(phases_.begin(), phases_.end(), t,
                                       [](double time, const Phase& phase) { return time < phase.begins; });
  const Phase& phase = *(behind - 1);
  const PathPiece& piece = pieces_[phase.piece];
  const double dt = t - phase.begins;
  const double s = std::min(piece.length, phase.s + phase.sd * dt + 0.5 * phase.sdd * dt * dt);
  const double sd = std::max(0.0, phase.sd + phase.sdd * dt);
  const Eigen::VectorXd slope = piece.slope(s);
  return {piece.at(s), slope * sd, slope * phase.sdd + piece.c * (sd * sd)};
}

Trajectory time_optimal(std::vector<PathPiece> pieces, const MotionLimits& limits, const TimingOptions& options) {
  if (pieces.empty()) return {};
  double duration = 0.0;
  std::vector<Trajectory::Phase> phases = Passes(pieces, limits, options).phases(duration);
  return {std::move(pieces), std::move(phases), duration};
}

}  // namespace hecaton::planner
