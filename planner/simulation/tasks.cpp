#include "planner/simulation/tasks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "planner/local/goal_objective.hpp"
#include "planner/methods/strategy/strategy.hpp"
#include "planner/model/inverse_kinematics.hpp"
#include "planner/model/whole_turns.hpp"
#include "planner/simulation/task_shortage.hpp"

namespace hecaton::planner {
namespace {

/// Initial guesses of the inverse kinematics lie this close to the cell's posture [rad].
constexpr double kPostureWidth = 0.2;
/// Configurations of a straight motion that are checked for contact.
constexpr int kStraightSamples = 60;
/// A joint of this range or more has every posture of at least half of a turn twice [rad].
constexpr double kTurnsMoreThanOnce = 3.0 * std::numbers::pi;
/// Postures drawn for an arm whose tool stays on a surface, until its tool lies in the task area.
constexpr int kPostures = 500;
/// Trials to draw arms one after the other. The first arms may leave no place for the last.
constexpr int kOneByOne = 5;
/// The tool lies in the task area within this distance [m].
constexpr double kAreaTolerance = 1e-3;

}  // namespace

struct TaskGenerator::Impl {
  explicit Impl(const Cell& task_cell) : cell(task_cell), clearance(cell) {
    // A flat area is in the plane of a planar arm: its points are within reach.
    for (const PlannedArm& planned : cell.arms) {
      on_surface.push_back(cell.tasks.half_height > 0.0 && tool_stays_on_surface(planned.arm));
    }
  }

  [[nodiscard]] int arms() const { return static_cast<int>(cell.arms.size()); }

  [[nodiscard]] JointVector draw_posture(const Arm& arm, Random& random) const {
    JointVector q(arm.model->joints());
    const bool any = cell.tasks.posture.empty();
    for (int j = 0; j < arm.model->joints(); ++j) {
      const double middle = any ? 0.0 : arm.named.at(cell.tasks.posture)[j];
      const double width = any ? std::numbers::pi : kPostureWidth;
      q[j] =
          random.uniform(std::max(arm.limits.lower[j], middle - width), std::min(arm.limits.upper[j], middle + width));
    }
    return q;
  }

  std::optional<JointVector> draw_arm(int i, Random& random) {
    const Arm& arm = cell.arms[i].arm;
    DrawTally& tally = tallies[i];
    ++tally.draws;
    const TaskArea& area = cell.tasks;
    const double radius = area.radius * std::sqrt(random.uniform());
    const double angle = 2.0 * std::numbers::pi * random.uniform();
    Pose X_WT = Pose::Identity();
    X_WT.translation() =
        area.frame(arm.X_WB) * (area.centre + Eigen::Vector3d(radius * std::cos(angle), radius * std::sin(angle),
                                                              random.uniform(-1.0, 1.0) * area.half_height));
    const JointVector start = draw_posture(arm, random);
    IkOptions options;
    options.free_rotation = FreeRotation::kAll;
    options.seeds = 2;
    options.iterations = 60;
    options.random_seed = random.next();
    bool reached = false;
    options.accept = [&](const JointVector& q) {
      reached = true;
      return clearance.clear_alone(i, q);
    };
    auto drawn = inverse_kinematics(arm, X_WT, start, options);
    if (!reached && on_surface[i]) {
      Random postures(options.random_seed);
      drawn = draw_on_surface(i, postures, reached);
    }
    tally.reached = tally.reached || reached;
    tally.clear = tally.clear || drawn.has_value();
    return drawn;
  }

  /// Draws postures until the tool of arm i lies in the task area and the arm is clear. `reached`: one lay there.
  std::optional<JointVector> draw_on_surface(int i, Random& random, bool& reached) {
    const Arm& arm = cell.arms[i].arm;
    const TaskArea& area = cell.tasks;
    for (int k = 0; k < kPostures; ++k) {
      JointVector q = draw_posture(arm, random);
      const Eigen::Vector3d offset = area.frame(arm.X_WB).inverse() * clearance.tool(i, q).translation() - area.centre;
      const bool inside = offset.head<2>().norm() <= area.radius + kAreaTolerance &&
                          std::abs(offset.z()) <= area.half_height + kAreaTolerance;
      if (!inside) continue;
      reached = true;
      if (clearance.clear_alone(i, q)) return q;
    }
    return std::nullopt;
  }

  /// For a shared task area: draws all arms together until they are clear of each other.
  std::optional<CellConfiguration> draw_all(Random& random, int attempts) {
    for (int attempt = 0; attempt < attempts; ++attempt) {
      CellConfiguration q;
      for (int i = 0; i < arms(); ++i) {
        auto drawn = draw_arm(i, random);
        if (!drawn) break;
        q.push_back(std::move(*drawn));
      }
      if (static_cast<int>(q.size()) == arms() && clearance.clear_of_each_other(q)) return q;
    }
    return std::nullopt;
  }

  std::optional<CellConfiguration> draw_configuration(Random& random, int attempts) {
    tallies.assign(arms(), {});
    clearance.forget_obstructions();
    if (!cell.tasks.pose_sequence.empty()) return sequence_pose(random.next() % cell.tasks.pose_sequence.size());
    if (!cell.tasks.problem.areas.empty()) {
      const std::size_t turn = random.next() % 2;
      return draw_in_areas(std::vector<std::size_t>(arms(), turn), random, attempts);
    }
    if (cell.tasks.of_each_arm) return draw_each(random, attempts);
    auto drawn = draw_all(random, attempts);
    const bool each_alone =
        std::all_of(tallies.begin(), tallies.end(), [](const DrawTally& tally) { return tally.clear; });
    // Four arms around one place are hardly ever clear of each other when they are drawn independently.
    for (int k = 0; !drawn && each_alone && arms() > 1 && k < kOneByOne; ++k) drawn = draw_each(random, attempts);
    return drawn;
  }

  /// For areas of their own, and where draw_all() fails: draws one arm after the other until it is clear of those
  /// before. Many arms drawn together would hardly ever be clear of each other.
  std::optional<CellConfiguration> draw_each(Random& random, int attempts) {
    CellConfiguration q;
    std::vector<int> placed;
    for (int i = 0; i < arms(); ++i) {
      const auto clear = [&](const JointVector& drawn) { return clearance.clear_of(i, drawn, placed); };
      std::optional<JointVector> drawn;
      for (int attempt = 0; attempt < attempts && !(drawn && clear(*drawn)); ++attempt) drawn = draw_arm(i, random);
      if (!drawn || !clear(*drawn)) return std::nullopt;
      q.push_back(std::move(*drawn));
      placed.push_back(i);
    }
    return q;
  }

  /// All arms at pose k of the sequence.
  [[nodiscard]] CellConfiguration sequence_pose(std::size_t k) const {
    CellConfiguration q;
    for (const PlannedArm& planned : cell.arms) q.push_back(planned.arm.named.at(cell.tasks.pose_sequence[k]));
    return q;
  }

  [[nodiscard]] static bool turns_more_than_once(const Arm& arm) {
    for (int j = 0; j < arm.model->joints(); ++j) {
      const bool wide = arm.limits.upper[j] - arm.limits.lower[j] >= kTurnsMoreThanOnce;
      if (wide && repeats_after_turn(*arm.model, j)) return true;
    }
    return false;
  }

  /// Adds whole turns to the goals of arms that turn more than once, towards the starts. Other arms and the motion of
  /// obstacles do not count on the way.
  void unwind(const CellConfiguration& starts, CellConfiguration& goals) {
    for (int i = 0; i < arms(); ++i) {
      const Arm& arm = cell.arms[i].arm;
      if (!turns_more_than_once(arm)) continue;
      goals[i] = turns_with_free_way(arm, goals[i], starts[i],
                                     [&](const JointVector& q) { return !clearance.stopped_alone(i, q); });
    }
  }

  [[nodiscard]] std::size_t nearest_sequence_pose(const CellConfiguration& q) const {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < cell.tasks.pose_sequence.size(); ++k) {
      const CellConfiguration there = sequence_pose(k);
      double distance = 0.0;
      for (int i = 0; i < arms(); ++i) distance += joint_difference(cell.arms[i].arm.limits, q[i], there[i]).norm();
      if (distance < least) {
        least = distance;
        nearest = k;
      }
    }
    return nearest;
  }

  /// Centres of the arm's areas in the motion problem; its home pose if it has none.
  [[nodiscard]] std::vector<JointVector> areas_of(int i) const {
    const Arm& arm = cell.arms[i].arm;
    const auto listed = cell.tasks.problem.areas.find(arm.name);
    if (listed == cell.tasks.problem.areas.end()) return {arm.home()};
    std::vector<JointVector> areas;
    for (const std::string& pose : listed->second) areas.push_back(arm.named.at(pose));
    return areas;
  }

  [[nodiscard]] std::size_t nearest_area(int i, const JointVector& q) const {
    const std::vector<JointVector> areas = areas_of(i);
    std::size_t nearest = 0;
    for (std::size_t k = 1; k < areas.size(); ++k) {
      if ((areas[k] - q).norm() < (areas[nearest] - q).norm()) nearest = k;
    }
    return nearest;
  }

  /// Uniform in the ball of the area, in the joints that the strategy moves.
  [[nodiscard]] JointVector draw_in_area(int i, std::size_t area, Random& random) const {
    const std::vector<JointVector> areas = areas_of(i);
    JointVector q = areas[area % areas.size()];
    if (areas.size() == 1) return q;
    const int n = avoiding_joints(parameters_of<StrategyParameters>(cell.arms[i].methods), static_cast<int>(q.size()));
    JointVector direction(n);
    for (auto& x : direction) x = random.normal();
    const double radius = cell.tasks.problem.spread * std::pow(random.uniform(), 1.0 / n);
    q.head(n) += radius * direction.normalized();
    return q;
  }

  /// Draws all arms, arm i in its area `area[i]`.
  std::optional<CellConfiguration> draw_in_areas(const std::vector<std::size_t>& area, Random& random, int attempts) {
    for (int attempt = 0; attempt < attempts; ++attempt) {
      CellConfiguration q;
      for (int i = 0; i < arms(); ++i) {
        const JointLimits& limits = cell.arms[i].arm.limits;
        JointVector drawn = draw_in_area(i, area[i], random);
        const bool within =
            (drawn.array() >= limits.lower.array()).all() && (drawn.array() <= limits.upper.array()).all();
        if (!within || !clearance.clear_alone(i, drawn)) break;
        q.push_back(std::move(drawn));
      }
      if (static_cast<int>(q.size()) == arms() && clearance.clear_of_each_other(q)) return q;
    }
    return std::nullopt;
  }

  Cell cell;
  RestClearance clearance;
  std::vector<bool> on_surface;    ///< of each arm: its tool stays on a surface in the area
  std::vector<DrawTally> tallies;  ///< of the last configuration
  std::string shortage;
};

TaskGenerator::TaskGenerator(const Cell& cell) : impl_(std::make_unique<Impl>(cell)) {}
TaskGenerator::~TaskGenerator() = default;
TaskGenerator::TaskGenerator(TaskGenerator&&) noexcept = default;

std::optional<CellConfiguration> TaskGenerator::draw_configuration(Random& random, int attempts) {
  auto drawn = impl_->draw_configuration(random, attempts);
  if (drawn) return drawn;
  for (std::size_t i = 0; i < impl_->tallies.size(); ++i) {
    impl_->tallies[i].most_frequent = impl_->clearance.most_frequent_obstruction(static_cast<int>(i));
  }
  impl_->shortage = why_no_configuration(impl_->cell, impl_->tallies);
  return drawn;
}

std::optional<CellConfiguration> TaskGenerator::draw_starts(Random& random) {
  auto starts = draw_configuration(random);
  if (!starts) return starts;
  CellConfiguration home = *starts;
  for (int i = 0; i < impl_->arms(); ++i) {
    const Arm& arm = impl_->cell.arms[i].arm;
    if (arm.named.contains("home")) home[i] = arm.home();
  }
  impl_->unwind(home, *starts);
  return starts;
}

const std::string& TaskGenerator::shortage() const {
  return impl_->shortage;
}

bool TaskGenerator::clear_at(double time, const CellConfiguration& starts) {
  return impl_->clearance.clear_at(time, starts);
}

std::optional<double> TaskGenerator::draw_time(Random& random, double span, const CellConfiguration& starts,
                                               int attempts) {
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const double time = random.uniform(0.0, span);
    if (clear_at(time, starts)) return time;
  }
  impl_->shortage = why_no_start_time(impl_->cell, attempts);
  return std::nullopt;
}

std::optional<CellConfiguration> TaskGenerator::draw_conflicting_goals(Random& random, const CellConfiguration& starts,
                                                                       int attempts) {
  const std::size_t poses = impl_->cell.tasks.pose_sequence.size();
  if (poses > 0) return impl_->sequence_pose((impl_->nearest_sequence_pose(starts) + 1) % poses);
  if (!impl_->cell.tasks.problem.areas.empty()) {
    std::vector<std::size_t> next;
    for (int i = 0; i < impl_->arms(); ++i) next.push_back(impl_->nearest_area(i, starts[i]) + 1);
    auto goals = impl_->draw_in_areas(next, random, attempts);
    if (!goals) impl_->shortage = why_no_configuration(impl_->cell, {});
    return goals;
  }
  for (int attempt = 0; attempt < attempts; ++attempt) {
    auto goals = draw_configuration(random);
    if (!goals) return std::nullopt;
    impl_->unwind(starts, *goals);
    // One arm has no conflict, nor have arms that cannot reach each other.
    const bool can_conflict = impl_->clearance.can_meet() || impl_->cell.tasks.clutter.count > 0;
    if (impl_->arms() == 1 || !can_conflict || straight_motion_collides(starts, *goals)) return goals;
  }
  impl_->shortage = why_no_conflict(impl_->cell, attempts);
  return std::nullopt;
}

bool TaskGenerator::straight_motion_collides(const CellConfiguration& starts, const CellConfiguration& goals) {
  CellConfiguration q = starts;
  std::vector<bool> touched(impl_->arms(), false);
  for (int sample = 1; sample < kStraightSamples; ++sample) {
    const double share = static_cast<double>(sample) / kStraightSamples;
    for (int i = 0; i < impl_->arms(); ++i) {
      const JointLimits& limits = impl_->cell.arms[i].arm.limits;
      q[i] = starts[i] + share * joint_difference(limits, starts[i], goals[i]);
    }
    impl_->clearance.note_touching(q, impl_->cell.tasks.clutter.count > 0, touched);
    const auto count = std::count(touched.begin(), touched.end(), true);
    if (count > 0 && (!impl_->cell.tasks.all_conflict || count == impl_->arms())) return true;
  }
  return false;
}

}  // namespace hecaton::planner
