#include "planner/global/plan.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <sstream>

namespace hecaton::planner::global {
namespace {

/// Clearance grades of edges, as shares of the wanted clearance.
constexpr double kGrades[] = {1.0, 0.25, 0.0};
constexpr int kWorstGrade = 2;

/// Shares of the edges beside a corner that a cut replaces, tried in this order.
constexpr float kCuts[] = {0.5F, 0.25F, 0.1F};

class Shortcutter {
 public:
  Shortcutter(const Points& path, const Validity& validity, const Space& space, const SimplifyOptions& options)
      : path_(path), validity_(validity), space_(space), options_(options), one_(space.stride), two_(space.stride) {
    for (int i = 0; i + 1 < path_.size(); ++i) grades_.push_back(grade_of(path_[i], path_[i + 1]));
  }

  /// Joins each point with the farthest one to which the edge is free.
  void join_farthest() {
    Points result(path_.stride());
    std::vector<int> grades;
    result.add(path_[0]);
    for (int from = 0; from + 1 < path_.size();) {
      int to = path_.size() - 1;
      while (to > from + 1 && (ended() || !keeps(path_[from], path_[to], worst(from, to)))) --to;
      result.add(path_[to]);
      grades.push_back(to == from + 1 ? grades_[from] : worst(from, to));
      from = to;
    }
    path_ = std::move(result);
    grades_ = std::move(grades);
  }

  /// Replaces each inner point by an edge between its two neighbouring edges, as far from the point as a share allows.
  void cut_corners() {
    Points result(path_.stride());
    std::vector<int> grades;
    const auto add = [&](const float* q, int grade) {
      result.add(q);
      grades.push_back(grade);
    };
    result.add(path_[0]);
    for (int i = 1; i + 1 < path_.size(); ++i) {
      const int grade = worst(i - 1, i + 1);
      if (cut(result[result.size() - 1], i, grade)) {
        add(one_.data(), grades_[i - 1]);
        add(two_.data(), grade);
      } else {
        add(path_[i], grades_[i - 1]);
      }
    }
    add(path_[path_.size() - 1], grades_.back());
    path_ = std::move(result);
    grades_ = std::move(grades);
  }
  [[nodiscard]] const Points& path() const { return path_; }
  [[nodiscard]] bool ended() const { return options_.ended && options_.ended(); }

 private:
  [[nodiscard]] bool keeps(const float* a, const float* b, int grade) const {
    return validity_.edge_free(a, b, checked(grade));
  }
  [[nodiscard]] EdgeCheck checked(int grade) const {
    EdgeCheck check = options_.check;
    check.clearance += kGrades[grade] * options_.clearance;
    check.proven = check.proven || check.clearance > 0.0;
    return check;
  }
  [[nodiscard]] int grade_of(const float* a, const float* b) const {
    int grade = options_.clearance > 0.0 ? 0 : kWorstGrade;
    while (grade < kWorstGrade && (ended() || !keeps(a, b, grade))) ++grade;
    return grade;
  }
  /// The worst grade of the edges between two points.
  [[nodiscard]] int worst(int from, int to) const {
    return *std::max_element(grades_.begin() + from, grades_.begin() + to);
  }
  /// Sets one_ and two_ to the ends of an edge that cuts off point i. `before`: the last point kept before it, which an
  /// earlier cut may have moved towards point i. False if no share has a free edge.
  bool cut(const float* before, int i, int grade) {
    const float* after = path_[i + 1];
    for (const float share : kCuts) {
      if (ended()) return false;
      space_.interpolate(path_[i], before, share, one_.data());
      space_.interpolate(path_[i], after, share, two_.data());
      if (!keeps(one_.data(), two_.data(), grade)) continue;
      // A part of an edge is sampled at other configurations than the whole edge, so it is checked again.
      if (checked(grade).proven) return true;
      if (keeps(before, one_.data(), grades_[i - 1]) && keeps(two_.data(), after, grades_[i])) return true;
    }
    return false;
  }

  Points path_;
  std::vector<int> grades_;  ///< of the edges: indices into kGrades
  const Validity& validity_;
  const Space& space_;
  const SimplifyOptions& options_;
  std::vector<float> one_;
  std::vector<float> two_;
};

std::vector<float> padded(const Validity& validity, std::span<const double> q) {
  std::vector<float> result(validity.stride(), 0.0F);
  std::transform(q.begin(), q.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

/// Calls `use` with the index of each continuous joint.
template <typename Use>
void for_each_continuous(const Validity& validity, const Use& use) {
  std::size_t i = 0;
  for (const CellGeometry& geometry : validity.planned()) {
    const JointLimits& limits = geometry.own_arm().limits;
    for (Eigen::Index j = 0; j < limits.lower.size(); ++j, ++i) {
      if (std::isinf(limits.lower[j]) && std::isinf(limits.upper[j])) use(i);
    }
  }
}

constexpr double kTurn = 2.0 * std::numbers::pi;

/// The full turns of continuous joints at q [rad]. They are removed before conversion to floats, which are finer near
/// 0.
std::vector<double> turns_at(const Validity& validity, std::span<const double> q) {
  std::vector<double> turns(q.size(), 0.0);
  for_each_continuous(validity, [&](std::size_t i) { turns[i] = kTurn * std::round(q[i] / kTurn); });
  return turns;
}

std::vector<double> minus(std::span<const double> q, std::span<const double> turns) {
  std::vector<double> result(q.begin(), q.end());
  for (std::size_t i = 0; i < result.size(); ++i) result[i] -= turns[i];
  return result;
}

std::optional<std::string> outside_limits(const Validity& validity, std::span<const double> q) {
  std::size_t i = 0;
  for (const CellGeometry& geometry : validity.planned()) {
    const Arm& arm = geometry.own_arm();
    for (int j = 0; j < arm.model->joints(); ++j, ++i) {
      if (std::isfinite(q[i]) && q[i] >= arm.limits.lower[j] && q[i] <= arm.limits.upper[j]) continue;
      std::ostringstream out;
      out << std::setprecision(8);
      out << "joint " << arm.model->joint_names[j] << " = " << q[i] << " must be within " << arm.limits.lower[j]
          << " … " << arm.limits.upper[j];
      return out.str();
    }
  }
  return std::nullopt;
}

/// Converts points to the plan's path. Its ends are exactly `start` and `goal`; the goal may differ by full turns.
/// `turns`: the turns that the points leave out (turns_at).
void set_path(const Validity& validity, const Points& points, std::span<const double> start,
              std::span<const double> goal, std::span<const double> turns, Plan& plan) {
  plan.path.clear();
  for (int i = 0; i < points.size(); ++i) {
    std::vector<double>& q = plan.path.emplace_back(points[i], points[i] + start.size());
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += turns[j];
  }
  plan.path.front().assign(start.begin(), start.end());
  const std::vector<double> last = plan.path.back();
  plan.path.back().assign(goal.begin(), goal.end());
  for_each_continuous(validity,
                      [&](std::size_t i) { plan.path.back()[i] += kTurn * std::round((last[i] - goal[i]) / kTurn); });
  plan.length = 0.0;
  for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < start.size(); ++j) sum += std::pow(plan.path[i + 1][j] - plan.path[i][j], 2);
    plan.length += std::sqrt(sum);
  }
}

}  // namespace

double length(const Points& path, const Space& space) {
  double sum = 0.0;
  for (int i = 0; i + 1 < path.size(); ++i) sum += space.distance(path[i], path[i + 1]);
  return sum;
}

Points simplified(const Points& path, const Validity& validity, const Space& space, const SimplifyOptions& options) {
  if (path.size() <= 2) return path;
  Shortcutter shortcutter(path, validity, space, options);
  shortcutter.join_farthest();
  for (int i = 0; i < options.passes && shortcutter.path().size() > 2 && !shortcutter.ended(); ++i) {
    shortcutter.cut_corners();
    shortcutter.join_farthest();
  }
  return shortcutter.path();
}

Space space_of(const Validity& validity, std::span<const double> start, std::span<const double> goal) {
  Space space = space_of(validity);
  space.period.clear();
  for_each_continuous(validity, [&](std::size_t i) {
    space.lower[i] = static_cast<float>(std::min(start[i], goal[i]) - std::numbers::pi);
    space.upper[i] = static_cast<float>(std::max(start[i], goal[i]) + std::numbers::pi);
  });
  return space;
}

Space space_of(const Validity& validity) {
  Space space{validity.dimensions(), validity.stride(), {}, {}};
  for (const CellGeometry& geometry : validity.planned()) {
    const JointLimits& limits = geometry.own_arm().limits;
    for (Eigen::Index j = 0; j < limits.lower.size(); ++j) {
      space.lower.push_back(static_cast<float>(limits.lower[j]));
      space.upper.push_back(static_cast<float>(limits.upper[j]));
    }
  }
  for_each_continuous(validity, [&](std::size_t i) {
    space.period.resize(space.lower.size(), 0.0F);
    space.period[i] = kFullTurn;
    space.lower[i] = -0.5F * kFullTurn;
    space.upper[i] = 0.5F * kFullTurn;
  });
  return space;
}

std::optional<std::string> reject(const Validity& validity, std::string_view which, std::span<const double> q) {
  std::ostringstream out;
  out << which;
  if (q.size() != static_cast<std::size_t>(validity.dimensions())) {
    out << " has " << q.size() << " joint values, but there are " << validity.dimensions() << " joints";
    return out.str();
  }
  if (const auto outside = outside_limits(validity, q)) return out.str() + ": " + *outside;
  if (validity.state_free(padded(validity, minus(q, turns_at(validity, q))).data())) return std::nullopt;
  const Validity::Nearest tightest = validity.tightest(q);
  if (tightest.distance <= 0.0) {
    out << " is in collision: " << tightest.a << " and " << tightest.b << " overlap by " << -1e3 * tightest.distance
        << " mm (minimum distance " << 1e3 * tightest.required << " mm); choose another " << which
        << ", or move what is in the way";
  } else {
    out << " is too close to collision: " << tightest.a << " and " << tightest.b << " are " << 1e3 * tightest.distance
        << " mm apart (minimum distance " << 1e3 * tightest.required << " mm); choose another " << which
        << ", or ask for less clearance";
  }
  return out.str();
}

Plan plan(const Validity& validity, std::span<const double> start, std::span<const double> goal,
          const PlanOptions& options) {
  Plan result;
  const std::uint64_t checks_before = validity.checks();
  if (const auto rejection = reject(validity, "start", start)) {
    result.status = PlanStatus::kStartInvalid;
    result.reason = *rejection;
    return result;
  }
  if (const auto rejection = reject(validity, "goal", goal)) {
    result.status = PlanStatus::kGoalInvalid;
    result.reason = *rejection;
    return result;
  }
  const Space space = space_of(validity);
  const std::vector<double> turns = turns_at(validity, start);
  const std::vector<float> from = padded(validity, minus(start, turns));
  const std::vector<float> to = padded(validity, minus(goal, turns_at(validity, goal)));
  if (options.record != nullptr) *options.record = SearchRecord();
  const SearchResult found = options.planner->search(
      {validity, space, from.data(), to.data(), options.seed, options.budget, options.check, options.record});
  result.iterations = found.iterations;
  result.nodes = found.nodes;
  result.status = found.status;
  if (result.solved()) {
    set_path(validity, found.path, start, goal, turns, result);
    if (options.simplify) simplify(validity, options, result);
  } else if (found.status == PlanStatus::kStuck) {
    result.reason = found.reason;
  } else {
    result.reason = "no path was found: the budget ended after " + std::to_string(found.iterations) + " samples and " +
                    std::to_string(found.nodes) + " nodes";
  }
  result.checks = validity.checks() - checks_before;
  return result;
}

void simplify(const Validity& validity, const PlanOptions& options, Plan& plan) {
  if (!plan.solved()) return;
  const std::vector<double> start = plan.path.front();
  const std::vector<double> goal = plan.path.back();
  const std::uint64_t checks_before = validity.checks();
  // The path is unwrapped: a full turn along it is a motion of its own.
  Space space = space_of(validity);
  space.period.clear();
  const std::vector<double> turns = turns_at(validity, start);
  Points points(space.stride);
  for (const std::vector<double>& q : plan.path) points.add(padded(validity, minus(q, turns)).data());
  SimplifyOptions shortcuts = options.shortcuts;
  shortcuts.check = options.check;
  shortcuts.ended = options.budget.ended;
  set_path(validity, simplified(points, validity, space, shortcuts), start, goal, turns, plan);
  plan.checks += validity.checks() - checks_before;
}

}  // namespace hecaton::planner::global
