#include "planner/strategy_search/motion_problem.hpp"

#include <algorithm>
#include <cmath>

#include "planner/local/random.hpp"
#include "planner/methods/strategy/strategy.hpp"
#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner {
namespace {

/// Draws of a free configuration before an error.
constexpr int kAttempts = 2000;
/// Number of starts; after faults they are reused in turn.
constexpr int kStarts = 64;

FlatBox flat_box(const Pose& X_WS, const Eigen::Vector3d& half) {
  FlatBox box{};
  const Eigen::Matrix3d R = X_WS.linear();
  const Eigen::Vector3d extent = R.cwiseAbs() * half;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) box.R[3 * k + i] = R(i, k);
    box.c[i] = X_WS.translation()[i];
    box.half[i] = half[i];
    box.low[i] = box.c[i] - extent[i];
    box.high[i] = box.c[i] + extent[i];
  }
  return box;
}

/// Half extents and centre of the bounding box in the shape's frame S [m].
std::pair<Eigen::Vector3d, Eigen::Vector3d> enclosing_box(const world::Shape& shape) {
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  if (const auto* box = std::get_if<world::Box>(&shape)) return {box->half_extents, origin};
  if (const auto* sphere = std::get_if<world::Sphere>(&shape))
    return {Eigen::Vector3d::Constant(sphere->radius), origin};
  if (const auto* capsule = std::get_if<world::Capsule>(&shape)) {
    return {{capsule->radius, capsule->radius, capsule->half_length + capsule->radius}, origin};
  }
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    return {{cylinder->radius, cylinder->radius, cylinder->half_length}, origin};
  }
  Eigen::AlignedBox3d bounds;
  for (const auto& vertex : std::get<world::Convex>(shape).hull->vertices) bounds.extend(vertex);
  return {0.5 * bounds.sizes(), bounds.center()};
}

/// Uniform in the ball of radius `radius` about `centre` [rad].
JointVector draw_in_ball(Random& random, const JointVector& centre, double radius) {
  const auto n = static_cast<double>(centre.size());
  JointVector direction(centre.size());
  for (auto& x : direction) x = random.normal();
  const double r = radius * std::pow(random.uniform(), 1.0 / n);
  return centre + (r / direction.norm()) * direction;
}

/// Sets FlatBody::boxes: boxes within the reach of the body from the first joint.
void find_boxes_in_reach(const FlatProblem& problem, FlatArm& arm) {
  const Eigen::Vector3d origin(arm.joint[0].p);
  for (int i = arm.fixed; i < arm.bodies; ++i) {
    FlatBody& body = arm.body[i];
    const double reach = reach_from_first_joint(arm, body) + body.radius + problem.distance;
    for (int k = 0; k < problem.boxes; ++k) {
      const Eigen::AlignedBox3d bounds(Eigen::Vector3d(problem.box[k].low), Eigen::Vector3d(problem.box[k].high));
      if (bounds.exteriorDistance(origin) <= reach) body.boxes |= 1U << k;
    }
  }
}

/// Upper bound of the error of distances in single precision [m]. Coordinates and products have a relative error of
/// 6·10⁻⁸; the squared distance of nearly parallel capsules has an error of 10⁻⁶ |d|² (rough_distance.hpp).
double rounding_of(const FlatProblem& problem) {
  double farthest = 1.0;
  double longest2 = 0.0;
  double thinnest = HUGE_VAL;
  for (int i = 0; i < problem.arms; ++i) {
    const FlatArm& arm = problem.arm[i];
    for (int k = 0; k < arm.bodies; ++k) {
      const FlatBody& body = arm.body[k];
      const double base = body.joint < 0 ? Eigen::Vector3d(body.p).norm() : Eigen::Vector3d(arm.joint[0].p).norm();
      const double reach = body.joint < 0 ? 0.0 : reach_from_first_joint(arm, body);
      farthest = std::max(farthest, base + reach);
      if (body.inverse2 > 0.0) longest2 = std::max(longest2, 1.0 / body.inverse2);
      thinnest = std::min(thinnest, body.radius);
    }
  }
  return 1e-5 * farthest + 2e-6 * longest2 / (problem.distance + 2.0 * thinnest);
}

/// A random stream for each purpose, arm and task, so that the first N of N + 1 tasks are the same as N tasks.
Random stream(std::uint64_t seed, int purpose, int arm, int index) {
  Random mixed(seed);
  const std::uint64_t a = mixed.next() ^ (static_cast<std::uint64_t>(purpose) << 56U);
  const std::uint64_t b = Random(a ^ (static_cast<std::uint64_t>(arm) << 40U)).next();
  return Random(b ^ static_cast<std::uint64_t>(index));
}

}  // namespace

RunKernel fastest_run() {
  return fastest(&baseline::run_strategies, &avx2::run_strategies);
}
ClearKernel fastest_clear() {
  return fastest(&baseline::clear_arms, &avx2::clear_arms);
}

PathsKernel fastest_paths() {
  return fastest(&baseline::precheck_paths, &avx2::precheck_paths);
}

StrategyProblem::StrategyProblem(const Cell& cell)
    : spread_(cell.tasks.problem.spread), mean_wait_(cell.tasks.problem.mean_wait) {
  const auto& areas = cell.tasks.problem.areas;
  if (areas.empty()) throw ProblemError("tasks.areas is missing: the cell has no motion problem");
  if (cell.arms.size() > kFlatArms) {
    throw ProblemError("the strategy search supports " + std::to_string(kFlatArms) + " arms; the cell has " +
                       std::to_string(cell.arms.size()));
  }
  const auto strategy = parameters_of<StrategyParameters>(cell.arms.front().methods);
  flat_.step = strategy.step;
  flat_.distance = strategy.distance;
  flat_.self_distance = cell.arms.front().parameters.damper.self_security_distance;
  for (const PlannedArm& planned : cell.arms) {
    const Arm& arm = planned.arm;
    const auto found = areas.find(arm.name);
    if (found == areas.end()) throw ProblemError("tasks.areas has no entry for arm " + arm.name);
    if (arm.model->has_followers) {
      throw ProblemError("some links of arm " + arm.name + " follow another joint; the strategy search needs arms " +
                         "whose links all have joints of their own");
    }
    const int avoiding = avoiding_joints(parameters_of<StrategyParameters>(planned.methods), arm.model->joints());
    if (avoiding < 2 || avoiding > arm.model->joints()) {
      throw ProblemError("arm " + arm.name + " needs at least two moving joints for a strategy");
    }
    flat_.arm[flat_.arms++] = flatten(arm, avoiding, arm.named.at(found->second.front()));
    names_.push_back(arm.name);
    area_names_.push_back(found->second);
    auto& centres = areas_.emplace_back();
    for (const std::string& pose : found->second) centres.push_back(arm.named.at(pose).head(avoiding));
  }
  for (const world::Obstacle& obstacle : cell.scene.obstacles) add_obstacle(obstacle);
  for (int i = 0; i < flat_.arms; ++i) find_boxes_in_reach(flat_, flat_.arm[i]);
  flat_.rounding = rounding_of(flat_);
}

void StrategyProblem::add_obstacle(const world::Obstacle& obstacle) {
  if (obstacle.attachment) {
    notes_.push_back("obstacle " + obstacle.name + " is carried by an arm and is ignored");
    return;
  }
  if (!std::holds_alternative<world::StaticMotion>(obstacle.motion)) {
    notes_.push_back("obstacle " + obstacle.name + " moves; the search uses its initial place");
  }
  for (const world::PlacedShape& placed : obstacle.shapes) {
    if (flat_.boxes == kFlatBoxes) {
      throw ProblemError("the strategy search supports " + std::to_string(kFlatBoxes) + " obstacle shapes");
    }
    const auto [half, centre] = enclosing_box(placed.shape);
    flat_.box[flat_.boxes++] = flat_box(obstacle.X_WO * placed.X_BS * Pose(Eigen::Translation3d(centre)), half);
    if (!std::holds_alternative<world::Box>(placed.shape)) {
      notes_.push_back("obstacle " + obstacle.name +
                       " has a shape that is not a box; the search uses its bounding box");
    }
  }
}

TaskSet StrategyProblem::draw(std::uint64_t seed, int tasks) const {
  enum Purpose { kGoal = 1, kWait = 2, kStart = 3 };
  TaskSet set;
  set.tasks = set.flat.tasks = tasks;
  set.flat.starts = kStarts;
  set.goals.resize(arms());
  set.waits.resize(arms());
  set.starts.resize(arms());
  const ClearKernel clear = fastest_clear();
  std::vector<JointVector> drawn;
  for (int i = 0; i < arms(); ++i) drawn.push_back(areas_[i].front());
  const auto is_clear = [&](int arm, bool others) {
    const double* q[kFlatArms] = {};
    for (int i = 0; i < arms(); ++i) q[i] = drawn[i].data();
    const unsigned found = clear(flat_, q, others);
    return arm < 0 ? found == (1U << arms()) - 1 : (found & (1U << arm)) != 0;
  };
  for (int i = 0; i < arms(); ++i) {
    const int areas = static_cast<int>(areas_[i].size());
    for (int task = 0; task < tasks; ++task) {
      Random waiting = stream(seed, kWait, i, task);
      set.waits[i].push_back(static_cast<std::int32_t>(-mean_wait_ * std::log(1.0 - waiting.uniform())));
      for (int area = 0; area < areas; ++area) {
        Random random = stream(seed, kGoal, i, task * areas + area);
        int attempt = 0;
        do {
          if (++attempt > kAttempts) {
            throw ProblemError("arm " + names_[i] + " has no goal clear of itself and of obstacles near pose " +
                               area_names_[i][area]);
          }
          drawn[i] = draw_in_ball(random, areas_[i][area], spread_);
        } while (!is_clear(i, false));
        set.goals[i].insert(set.goals[i].end(), drawn[i].data(), drawn[i].data() + drawn[i].size());
      }
    }
  }
  for (int start = 0; start < kStarts; ++start) {
    Random random = stream(seed, kStart, 0, start);
    int attempt = 0;
    do {
      if (++attempt > kAttempts) throw ProblemError("the arms are never clear of each other in their first areas");
      for (int i = 0; i < arms(); ++i) drawn[i] = draw_in_ball(random, areas_[i].front(), spread_);
    } while (!is_clear(-1, true));
    for (int i = 0; i < arms(); ++i) {
      set.starts[i].insert(set.starts[i].end(), drawn[i].data(), drawn[i].data() + drawn[i].size());
    }
  }
  for (int i = 0; i < arms(); ++i) {
    set.flat.areas[i] = static_cast<int>(areas_[i].size());
    set.flat.goals[i] = set.goals[i].data();
    set.flat.waits[i] = set.waits[i].data();
    set.flat.start[i] = set.starts[i].data();
  }
  return set;
}

void StrategyProblem::precheck_paths(TaskSet& set) const {
  constexpr std::size_t kMaxNumbers = 12'000'000;  // per arm: 48 MB
  constexpr std::size_t kSpare = 2 * kRoughLanes;  // groups may extend beyond the goal
  set.paths.resize(arms());
  for (int i = 0; i < arms(); ++i) {
    const FlatArm& arm = flat_.arm[i];
    const std::size_t numbers = rough_numbers(arm);
    TaskSet::Paths& paths = set.paths[i];
    paths = {};
    const double* from = set.starts[i].data();
    std::size_t steps = 0;
    for (int task = 0; task < set.tasks; ++task) {
      const int area = (task + 1) % set.flat.areas[i];
      const double* goal =
          set.flat.goals[i] + (static_cast<std::int64_t>(task) * set.flat.areas[i] + area) * arm.joints;
      const Eigen::Map<const Eigen::VectorXd> q_from(from, arm.joints);
      const Eigen::Map<const Eigen::VectorXd> q_to(goal, arm.joints);
      const std::size_t more = static_cast<std::size_t>((q_to - q_from).norm() / flat_.step) + kSpare;
      if ((steps + more) * numbers > kMaxNumbers) break;
      paths.first.push_back(static_cast<std::int32_t>(steps));
      steps += more;
      from = goal;
    }
    paths.self_free.resize(steps);
    paths.places.resize(steps * numbers);
    set.flat.paths[i] = {static_cast<int>(paths.first.size()), paths.first.data(), paths.self_free.data(),
                         paths.places.data()};
  }
  static const PathsKernel kernel = fastest_paths();
  kernel(flat_, set.flat);
}

}  // namespace hecaton::planner
