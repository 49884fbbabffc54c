#include "planner/strategy_search/run_kernel.hpp"

#include <algorithm>

#include "planner/methods/strategy/plane.hpp"
#include "planner/strategy_search/flat_kernels.hpp"
#include "planner/strategy_search/runner.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

/// States of a cycle agree within this in each coordinate of their planes [rad].
constexpr double kCycleTolerance = 1e-9;
/// Order of neighbours: as in the paper, and nearest to the goal first. They differ in the last two, back and
/// back-aside.
constexpr int kOrder[2][kNeighbours] = {{0, 1, 2, 3, 4}, {0, 1, 2, 4, 3}};

/// After so many steps towards the goal, four steps are checked at a time again.
constexpr int kStepsInRow = 2;

/// A cached lower bound of the distance of two arms.
struct KnownDistance {
  RoughNormal n;        ///< of a plane that separates them, from the arm with the higher number to the other
  double slack = -1.0;  ///< distance − h + travel of both, at an earlier time; minus the present travel: a bound
};

class Run {
 public:
  Run(const FlatProblem& problem, const FlatTasks& tasks, const FlatStrategy* strategies, const RunOptions& options,
      RunResult& result)
      : problem_(problem), tasks_(tasks), strategies_(strategies), options_(options), result_(result) {
    result = RunResult{};
    for (int i = 0; i < problem.arms; ++i) {
      runners_[i].arm = &problem.arm[i];
      runners_[i].rough.begin(problem.arm[i]);
      for (int& body : runners_[i].nearest) body = problem.arm[i].bodies - 1;
    }
  }

  void run() {
    reset();
    while (!finished_) {
      bool any_moves = false;
      std::int64_t earliest = -1;
      for (int i = 0; i < problem_.arms && !finished_; ++i) {
        Runner& runner = runners_[i];
        if (runner.moving) {
          ++result_.arm_ticks;
          move(i);
        } else if (tick_ >= runner.until) {
          begin_task(i);
        }
        any_moves = any_moves || runner.moving;
        if (!runner.moving && (earliest < 0 || runner.until < earliest)) earliest = runner.until;
        if (was_reset_) break;
      }
      if (options_.detect_cycles && !was_reset_ && !finished_ && earliest < 0) detect_cycle();
      if (was_reset_) {
        was_reset_ = false;
        continue;
      }
      ++tick_;
      if (!any_moves && earliest > tick_) tick_ = earliest;
    }
  }

 private:
  void reset() {
    const int start = resets_++ % tasks_.starts;
    for (int i = 0; i < problem_.arms; ++i) {
      Runner& runner = runners_[i];
      const FlatArm& arm = *runner.arm;
      for (int j = 0; j < arm.joints; ++j) runner.q[j] = tasks_.start[i][start * arm.joints + j];
      FourPlaces places;
      place_in_all_lanes(arm, runner.q, places);
      round_to(arm, places, runner.ahead);
      set_place(runner, runner.ahead.places[0]);
      runner.moving = false;
      runner.area = 0;
      runner.until = tick_ + wait(i);
    }
    clear_distances();
    unchanged_since_ = tick_;
  }

  /// Places one configuration in all four lanes.
  static void place_in_all_lanes(const FlatArm& arm, const double* q, FourPlaces& places) {
    Lanes lanes[kFlatJoints];
    for (int j = 0; j < arm.joints; ++j) lanes[j] = four(q[j]);
    place(arm, lanes, places);
  }

  static void round_to(const FlatArm& arm, const FourPlaces& places, CheckedPlaces& checked) {
    float* to[kLanes];
    for (int k = 0; k < kLanes; ++k) to[k] = checked.places[k].numbers;
    round_places(arm, places, to);
  }

  static void set_place(Runner& runner, const RoughPlace& place) {
    for (int k = 0; k < 6 * runner.rough.stride; k += kFloatLanes) {
      store(runner.own.numbers + k, load(place.numbers + k));
    }
    runner.here = runner.own.numbers;
  }

  [[nodiscard]] std::int64_t wait(int i) const { return tasks_.waits[i][runners_[i].task % tasks_.tasks]; }

  void begin_task(int i) {
    Runner& runner = runners_[i];
    const FlatArm& arm = *runner.arm;
    const int n = arm.joints;
    const int to = runner.next_area(tasks_.areas[i]);
    const int task = runner.task % tasks_.tasks;
    const double* goal = tasks_.goals[i] + (static_cast<std::int64_t>(task) * tasks_.areas[i] + to) * n;
    Plane& plane = runner.plane;
    plane.begin(runner.q, goal, n);
    strategy_direction(plane.u1, n, strategies_[i].coefficients, strategies_[i].direction, plane.u2,
                       static_cast<BasisOrder>(problem_.basis));
    plane.speed1 = plane.speed2 = 0.0;
    for (int j = 0; j < n; ++j) {
      plane.speed1 += std::fabs(plane.u1[j]) * arm.joint[j].lever;
      plane.speed2 += std::fabs(plane.u2[j]) * arm.joint[j].lever;
    }
    runner.state = {};
    runner.ahead.count = runner.ahead.next = 0;
    runner.clear_cache();
    runner.heads_for_goal = true;
    // Until the first fault, an arm starts each task from the goal before, whatever the strategy.
    const FlatPaths& paths = tasks_.paths[i];
    runner.known_step = resets_ == 1 && runner.task < paths.tasks ? paths.first[runner.task] : -1;
    runner.moving = true;
    runner.began = tick_ + 1;
    const double free_time = std::ceil(plane.distance / problem_.step - 1e-9);
    runner.limit = runner.began + static_cast<std::int64_t>(problem_.timeout_factor * free_time);
    unchanged_since_ = tick_;
  }

  /// Checks the next four places of the straight path.
  void look_ahead(Runner& runner) {
    CheckedPlaces& ahead = runner.ahead;
    ahead.next = 0;
    ahead.count = runner.plane.next_places(runner.state, problem_.step, ahead.at);
    check(runner, ahead);
  }

  /// Checked neighbours of the present place from number `first` on, in the order of trial.
  CheckedPlaces& neighbours(Runner& runner, int first) {
    const PlaneState& now = runner.state;
    for (int k = 0; k < kCachedPlaces; ++k) {
      if (runner.cache_key[k].is(now, first)) return runner.cache[k];
    }
    CheckedPlaces& checked = runner.cache[runner.replaced_next];
    runner.cache_key[runner.replaced_next] = {now.at, now.side, first};
    runner.replaced_next = runner.replaced_next + 1 == kCachedPlaces ? 0 : runner.replaced_next + 1;
    checked.count = kNeighbours - first < kLanes ? kNeighbours - first : kLanes;
    const PlaneFrame frame = plane_frame(now.at, runner.plane.distance);
    for (int k = 0; k < kLanes; ++k) {
      const int order = kOrder[problem_.nearest_first ? 1 : 0][k < checked.count ? first + k : first];
      checked.at[k] = neighbour(now, frame, runner.plane.distance, problem_.step, order);
    }
    check(runner, checked);
    return checked;
  }

  void check(Runner& runner, CheckedPlaces& checked) const {
    for (int& blocker : checked.blocker) blocker = -1;
    Lanes q[kFlatJoints];
    runner.plane.four_q(*runner.arm, checked.at, q);
    FourPlaces places;
    place(*runner.arm, q, places);
    check_self_free(problem_, *runner.arm, q, places);
    checked.self_free = places.self_free;
    round_to(*runner.arm, places, checked);
  }

  /// True if arm i may move to place k of `checked`.
  bool is_free(int i, CheckedPlaces& checked, int k) {
    if ((checked.self_free & (1U << k)) == 0) return false;
    if (checked.blocker[k] >= 0 && runners_[checked.blocker[k]].travelled < checked.blocked_until[k]) return false;
    double excess = 0.0;
    const int blocker = blocker_of(i, checked.at[k], checked.places[k].numbers, excess);
    if (blocker < 0) return true;
    checked.blocker[k] = blocker;
    checked.blocked_until[k] = runners_[blocker].travelled + excess;
    return false;
  }

  /// An arm that is nearer than h to arm i at this place (−1: none). `excess`: lower bound of how much nearer [m].
  int blocker_of(int i, const PlanePoint& at, const float* place, double& excess) {
    Runner& runner = runners_[i];
    const double step = distance_to(runner, at);
    const double surely = problem_.distance - problem_.rounding;
    for (int other = 0; other < problem_.arms; ++other) {
      if (other == i) continue;
      KnownDistance& known = known_[i < other ? i : other][i < other ? other : i];
      const double travelled = runner.travelled + step + runners_[other].travelled;
      if (known.slack > travelled) continue;
      const double distance = measure(i, place, other, known);
      if (distance < problem_.distance + problem_.rounding &&
          (distance < surely || !is_clear(runner, at, runners_[other]))) {
        excess = surely - distance;
        return other;
      }
      // The bound must hold at the present place as well, at most `step` away.
      known.slack = distance - problem_.rounding - problem_.distance + travelled - 2.0 * step;
    }
    return -1;
  }

  /// Distance of arm i at this place to another arm [m]; a lower bound if a plane separates them by h.
  double measure(int i, const float* place, int other, KnownDistance& known) {
    Runner& runner = runners_[i];
    const Runner& theirs = runners_[other];
    const float sign = i < other ? 1.0F : -1.0F;
    const RoughNormal before{sign * known.n.x, sign * known.n.y, sign * known.n.z};
    const float apart = rough_gap_along(runner.rough, place, theirs.rough, theirs.here, before);
    if (apart >= problem_.distance + problem_.rounding) return apart;
    RoughNormal n;
    const float distance =
        rough_distance(runner.rough, place, theirs.rough, theirs.here,
                       static_cast<float>(problem_.distance - problem_.rounding), runner.nearest[other], n);
    if (distance >= problem_.distance) known.n = {sign * n.x, sign * n.y, sign * n.z};
    return distance;
  }

  /// Checks the distance in double precision.
  [[nodiscard]] bool is_clear(const Runner& runner, const PlanePoint& at, const Runner& other) const {
    double q[kFlatJoints];
    FourPlaces places;
    runner.plane.q(*runner.arm, at, q);
    place_in_all_lanes(*runner.arm, q, places);
    if (other.moving) {
      other.plane.q(*other.arm, other.state.at, q);
    } else {
      std::copy(other.q, other.q + other.arm->joints, q);
    }
    FourPlaces theirs;
    place_in_all_lanes(*other.arm, q, theirs);
    SeenArm seen;
    seen.begin(*other.arm);
    seen.set(*other.arm, theirs, 0);
    NearestBodies nearest;
    return !(arm_distance(*runner.arm, places, 0, seen, problem_.distance, nearest) < problem_.distance);
  }

  [[nodiscard]] static double distance_to(const Runner& runner, const PlanePoint& to) {
    return std::fabs(to.x - runner.state.at.x) * runner.plane.speed1 +
           std::fabs(to.y - runner.state.at.y) * runner.plane.speed2;
  }

  void go_to(Runner& runner, const CheckedPlaces& checked, int k) {
    runner.travelled += distance_to(runner, checked.at[k]);
    runner.state.at = checked.at[k];
    set_place(runner, checked.places[k]);
  }

  /// The three behaviours of [Mediavilla02]: towards the goal, aside, turn.
  void move(int i) {
    Runner& runner = runners_[i];
    if (runner.heads_for_goal ? continue_to_goal(i) : go_towards_goal(i)) {
      if (runner.state.at.x == runner.plane.distance && runner.state.at.y == 0.0) return finish(i, false);
    } else if (!go_aside(i)) {
      runner.state.side = -runner.state.side;
    }
    if (tick_ + 1 >= runner.limit) finish(i, true);
  }

  bool continue_to_goal(int i) {
    Runner& runner = runners_[i];
    if (runner.known_step >= 0) {
      runner.heads_for_goal = continue_prechecked(i);
      return runner.heads_for_goal;
    }
    CheckedPlaces& ahead = runner.ahead;
    if (ahead.next == ahead.count) look_ahead(runner);
    if (is_free(i, ahead, ahead.next)) {
      go_to(runner, ahead, ahead.next++);
      return true;
    }
    ahead.count = ahead.next = 0;
    runner.heads_for_goal = false;
    return false;
  }

  bool continue_prechecked(int i) {
    Runner& runner = runners_[i];
    const FlatPaths& paths = tasks_.paths[i];
    if (paths.self_free[runner.known_step] == 0) return false;
    const PlaneFrame frame = plane_frame(runner.state.at, runner.plane.distance);
    const PlanePoint at = neighbour(runner.state, frame, runner.plane.distance, problem_.step, 0);
    const float* place = paths.places + runner.known_step * 6 * runner.rough.stride;
    double excess = 0.0;
    if (blocker_of(i, at, place, excess) >= 0) return false;
    runner.travelled += distance_to(runner, at);
    runner.state.at = at;
    runner.here = place;
    ++runner.known_step;
    for (int k = 0; k < 6; k += 2) __builtin_prefetch(place + (12 + k) * runner.rough.stride);
    return true;
  }

  bool go_towards_goal(int i) {
    Runner& runner = runners_[i];
    CheckedPlaces& around = neighbours(runner, 0);
    if (!is_free(i, around, 0)) return false;
    go_to(runner, around, 0);
    if (runner.known_step >= 0) ++runner.known_step;
    runner.heads_for_goal = ++runner.steps_in_row >= kStepsInRow;
    return true;
  }

  bool go_aside(int i) {
    Runner& runner = runners_[i];
    runner.steps_in_row = 0;
    CheckedPlaces* checked = &neighbours(runner, 0);
    int k = 1;
    while (k < kLanes && !is_free(i, *checked, k)) ++k;
    if (k == kLanes) {
      checked = &neighbours(runner, kLanes);
      k = 0;
      if (!is_free(i, *checked, k)) return false;
    }
    go_to(runner, *checked, k);
    runner.known_step = -1;
    return true;
  }

  /// Ends a task, at its goal or as a fault. Tasks beyond N are simulated but not counted.
  void finish(int i, bool fault) {
    Runner& runner = runners_[i];
    const std::int64_t time = fault ? runner.limit - runner.began : tick_ + 1 - runner.began;
    if (runner.task < tasks_.tasks) {
      const double t = static_cast<double>(time);
      ++result_.tasks[i];
      result_.faults[i] += fault ? 1 : 0;
      result_.time[i] += t;
      result_.time2[i] += t * t;
      if (options_.times[i] != nullptr) options_.times[i][runner.task] = static_cast<std::int32_t>(time);
      if (fault && options_.stop_at_fault) finished_ = true;
      ++finished_tasks_;
      if (options_.ended != nullptr && options_.ended(options_.context, finished_tasks_)) finished_ = true;
    }
    runner.plane.q(*runner.arm, runner.state.at, runner.q);
    runner.area = runner.next_area(tasks_.areas[i]);
    ++runner.task;
    runner.moving = false;
    runner.until = tick_ + 1 + wait(i);
    unchanged_since_ = tick_;
    bool all_done = true;
    for (int k = 0; k < problem_.arms; ++k) all_done = all_done && runners_[k].task >= tasks_.tasks;
    finished_ = finished_ || all_done;
    // Differs from the paper, which leaves open what follows a fault: all arms restart, and interrupted tasks are
    // repeated.
    if (fault && !finished_) {
      tick_ = runner.limit;
      reset();
      was_reset_ = true;
    }
  }

  /// Cycle detection by Brent's method. While all arms move, their places and sides determine the future. If they
  /// repeat, no arm will arrive, and the first time-out is the fault.
  void detect_cycle() {
    if (snapshot_tick_ < unchanged_since_) {
      take_snapshot(1);
      return;
    }
    bool same = true;
    for (int i = 0; i < problem_.arms && same; ++i) {
      const PlaneState& now = runners_[i].state;
      same = now.side == snapshot_[i].side && std::fabs(now.at.x - snapshot_[i].at.x) < kCycleTolerance &&
             std::fabs(now.at.y - snapshot_[i].at.y) < kCycleTolerance;
    }
    if (same) {
      int first = 0;
      for (int i = 1; i < problem_.arms; ++i) {
        if (runners_[i].limit < runners_[first].limit) first = i;
      }
      finish(first, true);
    } else if (tick_ - snapshot_tick_ >= power_) {
      take_snapshot(2 * power_);
    }
  }

  void take_snapshot(std::int64_t power) {
    for (int i = 0; i < problem_.arms; ++i) snapshot_[i] = runners_[i].state;
    snapshot_tick_ = tick_;
    power_ = power;
  }

  void clear_distances() {
    for (auto& row : known_) {
      for (KnownDistance& known : row) known = {};
    }
    for (int i = 0; i < problem_.arms; ++i) runners_[i].travelled = 0.0;
  }

  const FlatProblem& problem_;
  const FlatTasks& tasks_;
  const FlatStrategy* strategies_;
  const RunOptions& options_;
  RunResult& result_;
  Runner runners_[kFlatArms];
  KnownDistance known_[kFlatArms][kFlatArms];
  std::int64_t tick_ = 0;
  std::int64_t finished_tasks_ = 0;  ///< of all arms
  int resets_ = 0;
  bool finished_ = false;
  bool was_reset_ = false;
  std::int64_t unchanged_since_ = 0;  ///< when an arm last began or ended a task
  PlaneState snapshot_[kFlatArms];
  std::int64_t snapshot_tick_ = -1;
  std::int64_t power_ = 1;
};

/// Checks the places of a straight path, four at a time, up to the goal.
void precheck_path(const FlatProblem& problem, const FlatArm& arm, const Plane& plane, std::uint8_t* self_free,
                   float* places) {
  const std::ptrdiff_t numbers = rough_numbers(arm);
  PlaneState state;
  while (plane_frame(state.at, plane.distance).left > 0.0) {
    PlanePoint at[kLanes];
    const int count = plane.next_places(state, problem.step, at);
    Lanes q[kFlatJoints];
    plane.four_q(arm, at, q);
    FourPlaces four_places;
    place(arm, q, four_places);
    check_self_free(problem, arm, q, four_places);
    float* to[kLanes];
    for (int k = 0; k < kLanes; ++k) to[k] = places + k * numbers;
    round_places(arm, four_places, to);
    for (int k = 0; k < kLanes; ++k) self_free[k] = (four_places.self_free >> k) & 1U;
    self_free += count;
    places += count * numbers;
    state.at = at[count - 1];
  }
}

}  // namespace

void run_strategies(const FlatProblem& problem, const FlatTasks& tasks, const FlatStrategy* strategies,
                    const RunOptions& options, RunResult& result) {
  Run run(problem, tasks, strategies, options, result);
  run.run();
}

unsigned clear_arms(const FlatProblem& problem, const double* const* q, bool others) {
  static_assert(kFlatArms <= 32);
  FourPlaces places[kFlatArms];
  SeenArm seen[kFlatArms];
  unsigned clear = 0;
  for (int i = 0; i < problem.arms; ++i) {
    const FlatArm& arm = problem.arm[i];
    Lanes lanes[kFlatJoints];
    for (int j = 0; j < arm.joints; ++j) lanes[j] = four(q[i][j]);
    place(arm, lanes, places[i]);
    check_self_free(problem, arm, lanes, places[i]);
    if ((places[i].self_free & 1U) != 0) clear |= 1U << i;
    seen[i].begin(arm);
    seen[i].set(arm, places[i], 0);
  }
  for (int i = 0; others && i < problem.arms; ++i) {
    for (int k = 0; k < problem.arms; ++k) {
      if (k == i) continue;
      NearestBodies nearest;
      const double distance = arm_distance(problem.arm[i], places[i], 0, seen[k], problem.distance, nearest);
      if (distance < problem.distance) clear &= ~(1U << i);
    }
  }
  return clear;
}

void precheck_paths(const FlatProblem& problem, const FlatTasks& tasks) {
  for (int i = 0; i < problem.arms; ++i) {
    const FlatArm& arm = problem.arm[i];
    const FlatPaths& paths = tasks.paths[i];
    double q[kFlatJoints];
    for (int j = 0; j < arm.joints; ++j) q[j] = tasks.start[i][j];
    int area = 0;
    for (int task = 0; task < paths.tasks; ++task) {
      area = area + 1 == tasks.areas[i] ? 0 : area + 1;
      Plane plane;
      plane.begin(q, tasks.goals[i] + (static_cast<std::int64_t>(task) * tasks.areas[i] + area) * arm.joints,
                  arm.joints);
      const auto first = static_cast<std::int64_t>(paths.first[task]);
      precheck_path(problem, arm, plane, paths.self_free + first, paths.places + first * rough_numbers(arm));
      plane.q(arm, {plane.distance, 0.0}, q);
    }
  }
}

}  // namespace hecaton::planner::HECATON_ISA
