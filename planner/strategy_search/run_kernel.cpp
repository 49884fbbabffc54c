#include "planner/strategy_search/run_kernel.hpp"

#include <algorithm>

#include "planner/methods/strategy/plane.hpp"
#include "planner/strategy_search/flat_kernels.hpp"
#include "planner/strategy_search/runner.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

/// States of a cycle agree as exactly as this in every coordinate of their planes [rad].
constexpr double kSame = 1e-9;
/// In the paper's order, and nearest to the goal first: of the last two, straight back is nearer than back and aside.
constexpr int kOrder[2][kNeighbours] = {{0, 1, 2, 3, 4}, {0, 1, 2, 4, 3}};

/// So many steps towards the goal after one aside, and the way counts as clear.
constexpr int kStepsInRow = 2;

/// What is known of the distance of two arms: it was so much when they had travelled so far.
struct KnownDistance {
  RoughNormal n;        ///< from the arm of the higher number to the other, across what lay between them last
  double slack = -1.0;  ///< distance − h − what both had travelled, at an earlier time; + what they have: a bound
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
      if (options_.find_cycles && !was_reset_ && !finished_ && earliest < 0) watch_for_cycle();
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
      place_all(arm, runner.q, places);
      put_rough(arm, places, runner.ahead);
      stand_at(runner, runner.ahead.places[0]);
      runner.moving = false;
      runner.area = 0;
      runner.until = tick_ + wait(i);
    }
    forget_distances();
    unchanged_since_ = tick_;
  }

  /// The same configuration four times.
  static void place_all(const FlatArm& arm, const double* q, FourPlaces& places) {
    Lanes lanes[kFlatJoints];
    for (int j = 0; j < arm.joints; ++j) lanes[j] = four(q[j]);
    place(arm, lanes, places);
  }

  static void put_rough(const FlatArm& arm, const FourPlaces& places, Looked& looked) {
    float* to[kLanes];
    for (int k = 0; k < kLanes; ++k) to[k] = looked.places[k].numbers;
    round_places(arm, places, to);
  }

  static void stand_at(Runner& runner, const RoughPlace& place) {
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
    runner.forget_places();
    runner.heads_for_goal = true;
    // Until a fault, who has arrived has done so on the same goals whatever the strategy.
    const FlatPaths& paths = tasks_.paths[i];
    runner.known_step = resets_ == 1 && runner.task < paths.tasks ? paths.first[runner.task] : -1;
    runner.moving = true;
    runner.began = tick_ + 1;
    const double free_time = std::ceil(plane.distance / problem_.step - 1e-9);
    runner.limit = runner.began + static_cast<std::int64_t>(problem_.timeout_factor * free_time);
    unchanged_since_ = tick_;
  }

  /// The next four places of the straight way, or fewer up to the goal.
  void look_ahead(Runner& runner) {
    Looked& ahead = runner.ahead;
    ahead.next = 0;
    ahead.count = runner.plane.next_places(runner.state, problem_.step, ahead.at);
    look(runner, ahead);
  }

  /// Neighbours of the present place, from `first` on, in the order in which they are tried.
  Looked& neighbours(Runner& runner, int first) {
    const PlaneState& now = runner.state;
    for (int k = 0; k < kKnownPlaces; ++k) {
      if (runner.known_by[k].is(now, first)) return runner.known[k];
    }
    Looked& looked = runner.known[runner.forgotten];
    runner.known_by[runner.forgotten] = {now.at, now.side, first};
    runner.forgotten = runner.forgotten + 1 == kKnownPlaces ? 0 : runner.forgotten + 1;
    looked.count = kNeighbours - first < kLanes ? kNeighbours - first : kLanes;
    const PlaneFrame frame = plane_frame(now.at, runner.plane.distance);
    for (int k = 0; k < kLanes; ++k) {
      const int order = kOrder[problem_.nearest_first ? 1 : 0][k < looked.count ? first + k : first];
      looked.at[k] = neighbour(now, frame, runner.plane.distance, problem_.step, order);
    }
    look(runner, looked);
    return looked;
  }

  void look(Runner& runner, Looked& looked) const {
    for (int& blocker : looked.blocker) blocker = -1;
    Lanes q[kFlatJoints];
    runner.plane.four_q(*runner.arm, looked.at, q);
    FourPlaces places;
    place(*runner.arm, q, places);
    check_alone(problem_, *runner.arm, q, places);
    looked.alone = places.alone;
    put_rough(*runner.arm, places, looked);
  }

  /// Arm i may go to what it looked at in lane k.
  bool is_free(int i, Looked& looked, int k) {
    if ((looked.alone & (1U << k)) == 0) return false;
    if (looked.blocker[k] >= 0 && runners_[looked.blocker[k]].travelled < looked.blocked_until[k]) return false;
    double excess = 0.0;
    const int blocker = nearer_than_h(i, looked.at[k], looked.places[k].numbers, excess);
    if (blocker < 0) return true;
    looked.blocker[k] = blocker;
    looked.blocked_until[k] = runners_[blocker].travelled + excess;
    return false;
  }

  /// Which arm is nearer than h to arm i there (−1: none), and by how much at least [m].
  int nearer_than_h(int i, const PlanePoint& at, const float* place, double& excess) {
    Runner& runner = runners_[i];
    const double way = distance_to(runner, at);
    const double surely = problem_.distance - problem_.rounding;
    for (int other = 0; other < problem_.arms; ++other) {
      if (other == i) continue;
      KnownDistance& known = known_[i < other ? i : other][i < other ? other : i];
      const double travelled = runner.travelled + way + runners_[other].travelled;
      if (known.slack > travelled) continue;
      const double distance = measure(i, place, other, known);
      if (distance < problem_.distance + problem_.rounding &&
          (distance < surely || !is_clear(runner, at, runners_[other]))) {
        excess = surely - distance;
        return other;
      }
      // From there back to here it is `way` at most: true for either place.
      known.slack = distance - problem_.rounding - problem_.distance + travelled - 2.0 * way;
    }
    return -1;
  }

  /// Distance of arm i there to another; if they are clear of each other it may say less.
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

  /// In double precision.
  [[nodiscard]] bool is_clear(const Runner& runner, const PlanePoint& at, const Runner& other) const {
    double q[kFlatJoints];
    FourPlaces places;
    runner.plane.q(*runner.arm, at, q);
    place_all(*runner.arm, q, places);
    if (other.moving) {
      other.plane.q(*other.arm, other.state.at, q);
    } else {
      std::copy(other.q, other.q + other.arm->joints, q);
    }
    FourPlaces theirs;
    place_all(*other.arm, q, theirs);
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

  void go_to(Runner& runner, const Looked& looked, int k) {
    runner.travelled += distance_to(runner, looked.at[k]);
    runner.state.at = looked.at[k];
    stand_at(runner, looked.places[k]);
  }

  /// The three behaviours.
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
    Looked& ahead = runner.ahead;
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
    if (paths.alone[runner.known_step] == 0) return false;
    const PlaneFrame frame = plane_frame(runner.state.at, runner.plane.distance);
    const PlanePoint at = neighbour(runner.state, frame, runner.plane.distance, problem_.step, 0);
    const float* place = paths.places + runner.known_step * 6 * runner.rough.stride;
    double excess = 0.0;
    if (nearer_than_h(i, at, place, excess) >= 0) return false;
    runner.travelled += distance_to(runner, at);
    runner.state.at = at;
    runner.here = place;
    ++runner.known_step;
    for (int k = 0; k < 6; k += 2) __builtin_prefetch(place + (12 + k) * runner.rough.stride);
    return true;
  }

  bool go_towards_goal(int i) {
    Runner& runner = runners_[i];
    Looked& around = neighbours(runner, 0);
    if (!is_free(i, around, 0)) return false;
    go_to(runner, around, 0);
    if (runner.known_step >= 0) ++runner.known_step;
    runner.heads_for_goal = ++runner.steps_in_row >= kStepsInRow;
    return true;
  }

  bool go_aside(int i) {
    Runner& runner = runners_[i];
    runner.steps_in_row = 0;
    Looked* looked = &neighbours(runner, 0);
    int k = 1;
    while (k < kLanes && !is_free(i, *looked, k)) ++k;
    if (k == kLanes) {
      looked = &neighbours(runner, kLanes);
      k = 0;
      if (!is_free(i, *looked, k)) return false;
    }
    go_to(runner, *looked, k);
    runner.known_step = -1;
    return true;
  }

  /// The task is over, reached or as a fault; those beyond N are done, but not counted.
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
    // differs from paper: what follows a fault it leaves open; all arms begin anew, and who was interrupted repeats.
    if (fault && !finished_) {
      tick_ = runner.limit;
      reset();
      was_reset_ = true;
    }
  }

  /// While all arms are under way nothing but their places and sides decides what comes (Brent's method): when these
  /// come again, nobody arrives any more, and the first whose time is over is the fault.
  void watch_for_cycle() {
    if (snapshot_tick_ < unchanged_since_) {
      take_snapshot(1);
      return;
    }
    bool same = true;
    for (int i = 0; i < problem_.arms && same; ++i) {
      const PlaneState& now = runners_[i].state;
      same = now.side == snapshot_[i].side && std::fabs(now.at.x - snapshot_[i].at.x) < kSame &&
             std::fabs(now.at.y - snapshot_[i].at.y) < kSame;
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

  void forget_distances() {
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
  int resets_ = 0;
  bool finished_ = false;
  bool was_reset_ = false;
  std::int64_t unchanged_since_ = 0;  ///< the last time that an arm began or ended a task
  PlaneState snapshot_[kFlatArms];
  std::int64_t snapshot_tick_ = -1;
  std::int64_t power_ = 1;
};

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
    check_alone(problem, arm, lanes, places[i]);
    if ((places[i].alone & 1U) != 0) clear |= 1U << i;
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

}  // namespace hecaton::planner::HECATON_ISA
