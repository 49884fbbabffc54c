#include "planner/global/plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

namespace hecaton::planner::global {
namespace {

std::vector<float> padded(const Validity& validity, std::span<const double> q) {
  std::vector<float> result(validity.stride(), 0.0F);
  std::transform(q.begin(), q.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

/// Calls `use` with the index of each coordinate of a continuous joint.
template <typename Use>
void each_turning(const Validity& validity, const Use& use) {
  std::size_t i = 0;
  for (const CellGeometry& geometry : validity.planned()) {
    const JointLimits& limits = geometry.own_arm().limits;
    for (Eigen::Index j = 0; j < limits.lower.size(); ++j, ++i) {
      if (std::isinf(limits.lower[j]) && std::isinf(limits.upper[j])) use(i);
    }
  }
}

constexpr double kWholeTurn = 2.0 * std::numbers::pi;

/// What continuous joints have turned at q, in whole turns [rad]: floats near zero are finer.
std::vector<double> turns_at(const Validity& validity, std::span<const double> q) {
  std::vector<double> turns(q.size(), 0.0);
  each_turning(validity, [&](std::size_t i) { turns[i] = kWholeTurn * std::round(q[i] / kWholeTurn); });
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
      out << "joint " << arm.model->joint_names[j] << " = " << q[i] << " must be within " << arm.limits.lower[j]
          << " … " << arm.limits.upper[j];
      return out.str();
    }
  }
  return std::nullopt;
}

bool is_proven(const Points& path, const Validity& validity) {
  for (int i = 0; i + 1 < path.size(); ++i) {
    if (!validity.proven_free(path[i], path[i + 1])) return false;
  }
  return true;
}

/// As fine as need be: most paths that a coarse search finds stand a fine check.
SearchResult certified_search(SearchProblem problem, const PlanOptions& options) {
  SearchResult found;
  std::uint64_t iterations = 0;
  for (const EdgeCheck check : {EdgeCheck{1}, EdgeCheck{3}, EdgeCheck{1, true}}) {
    problem.check = check;
    if (options.record != nullptr) *options.record = SearchRecord();
    found = options.planner->search(problem);
    found.iterations = iterations += found.iterations;
    if (!found.solved() || !options.certify) return found;
    // In a closed space the path has been moved by whole turns: floats round.
    if ((check.proven && !problem.space.closed()) || is_proven(found.path, problem.validity)) return found;
  }
  found.status = PlanStatus::kBudgetEnded;
  return found;
}

/// Floats round: the ends are what was asked for, the goal whole turns aside where the path gets there. `turns`: what
/// the points leave out (turns_at).
void take_path(const Validity& validity, const Points& points, std::span<const double> start,
               std::span<const double> goal, std::span<const double> turns, Plan& plan) {
  plan.path.clear();
  for (int i = 0; i < points.size(); ++i) {
    std::vector<double>& q = plan.path.emplace_back(points[i], points[i] + start.size());
    for (std::size_t j = 0; j < q.size(); ++j) q[j] += turns[j];
  }
  plan.path.front().assign(start.begin(), start.end());
  const std::vector<double> last = plan.path.back();
  plan.path.back().assign(goal.begin(), goal.end());
  each_turning(validity, [&](std::size_t i) {
    plan.path.back()[i] += kWholeTurn * std::round((last[i] - goal[i]) / kWholeTurn);
  });
  plan.length = 0.0;
  for (std::size_t i = 0; i + 1 < plan.path.size(); ++i) {
    double sum = 0.0;
    for (std::size_t j = 0; j < start.size(); ++j) sum += std::pow(plan.path[i + 1][j] - plan.path[i][j], 2);
    plan.length += std::sqrt(sum);
  }
}

}  // namespace

Space space_of(const Validity& validity, std::span<const double> start, std::span<const double> goal) {
  Space space = space_of(validity);
  space.turns.clear();
  each_turning(validity, [&](std::size_t i) {
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
  each_turning(validity, [&](std::size_t i) {
    space.turns.resize(space.lower.size(), 0.0F);
    space.turns[i] = kTurn;
    space.lower[i] = -0.5F * kTurn;
    space.upper[i] = 0.5F * kTurn;
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
        << " mm";
  } else {
    out << " leaves too little room: " << tightest.a << " and " << tightest.b << " are " << 1e3 * tightest.distance
        << " mm apart, and " << 1e3 * tightest.wanted << " mm are wanted";
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
  const SearchResult found = certified_search(
      {validity, space, from.data(), to.data(), options.seed, options.budget, {}, options.record}, options);
  result.iterations = found.iterations;
  result.nodes = found.nodes;
  result.status = found.status;
  if (result.solved()) {
    take_path(validity, found.path, start, goal, turns, result);
    if (options.simplify) simplify(validity, options, result);
  } else if (found.status == PlanStatus::kStuck) {
    result.reason = found.reason;
  } else {
    result.reason = "no path was found with " + std::to_string(found.iterations) + " samples and " +
                    std::to_string(found.nodes) + " nodes before the budget ended";
  }
  result.checks = validity.checks() - checks_before;
  return result;
}

void simplify(const Validity& validity, const PlanOptions& options, Plan& plan) {
  if (!plan.solved()) return;
  const std::vector<double> start = plan.path.front();
  const std::vector<double> goal = plan.path.back();
  const std::uint64_t checks_before = validity.checks();
  // The way is there: from here on a whole turn is a way of its own.
  Space space = space_of(validity);
  space.turns.clear();
  const std::vector<double> turns = turns_at(validity, start);
  Points points(space.stride);
  for (const std::vector<double>& q : plan.path) points.add(padded(validity, minus(q, turns)).data());
  SimplifyOptions shortcuts = options.shortcuts;
  shortcuts.seed = options.seed;
  shortcuts.ended = options.budget.ended;
  Points shorter = simplified(points, validity, space, shortcuts);
  if (options.certify && !is_proven(shorter, validity)) {
    shortcuts.check.proven = true;
    shorter = simplified(points, validity, space, shortcuts);
  }
  take_path(validity, shorter, start, goal, turns, plan);
  plan.checks += validity.checks() - checks_before;
}

}  // namespace hecaton::planner::global
