/// A tick of a PUMA among two others and moving obstacles, along real journeys, and where its time goes: kinematics,
/// distances, rows, quadratic programme. FCL's public distance on the same near pairs is timed in the same run.
/// Counters: median, p99 and max of single calls [µs].

#include <array>
#include <vector>

#include <benchmark/benchmark.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/goal_objective.hpp"
#include "planner/local/limit_rows.hpp"
#include "planner/local/velocity_damper.hpp"
#include "planner/simulation/cell_simulation.hpp"
#include "planner/tick.hpp"
#include "services/config/cell_file.hpp"
#include "tests/bench/timings.hpp"
#include "world/sim/obstacle_motion.hpp"

namespace {

using namespace hecaton;
using namespace hecaton::planner;

constexpr double kInfluence = 0.2;  // what a tick at usual speed looks at [m]

/// One instant of the cell as arm 0's planner meets it.
struct Instant {
  std::vector<ArmObservation> arms;
  std::vector<world::ObstacleState> obstacles;
  JointVector q_goal;
};

struct Journeys {
  Cell cell = config::load_cell_file(HECATON_SOURCE_DIR "/deploy/cells/three_puma.yaml").cell;
  CellGeometry geometry = make_geometry(cell);
  std::vector<Instant> instants;

  static CellGeometry make_geometry(const Cell& cell) {
    std::vector<Arm> arms;
    for (const PlannedArm& planned : cell.arms) arms.push_back(planned.arm);
    CellGeometry geometry(arms, 0);
    geometry.set_obstacles(cell.scene.obstacles);
    return geometry;
  }

  /// States along simulated episodes of conflicting goals.
  Journeys() {
    TaskGenerator generator(cell);
    Random random(7);
    for (int episode = 0; episode < 12; ++episode) {
      const auto starts = generator.draw_configuration(random);
      const auto goals = generator.draw_conflicting_goals(random, *starts);
      CellConfiguration before = *starts;
      EpisodeOptions options;
      options.seed = random.next();
      options.observe = [&](double now, const CellConfiguration& q) {
        Instant instant;
        for (std::size_t i = 0; i < q.size(); ++i) {
          instant.arms.push_back({q[i], (q[i] - before[i]) / cell.timing.control_period, 0.0, true, true});
        }
        for (const auto& obstacle : cell.scene.obstacles) {
          const auto at = world::motion_at(obstacle, now);
          instant.obstacles.push_back({at.X_WO, at.velocity, 0.0});
        }
        instant.q_goal = (*goals)[0];
        instants.push_back(std::move(instant));
        before = q;
      };
      static_cast<void>(simulate_episode(cell, *starts, *goals, options));
    }
  }

  void place(const Instant& instant, std::vector<Kinematics>& out) const {
    out.resize(cell.arms.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Arm& arm = cell.arms[i].arm;
      forward_kinematics(*arm.model, arm.X_WB, instant.arms[i].q, out[i]);
    }
  }
};

const Journeys& journeys() {
  static const Journeys all;
  return all;
}

/// Times `work(instant)` alone for every instant; `prepare(instant)` runs before, untimed.
template <typename Prepare, typename Work>
void over_journeys(benchmark::State& state, const Prepare& prepare, const Work& work) {
  bench::Timings timings("");
  std::size_t next = 0;
  for (auto _ : state) {
    const Instant& instant = journeys().instants[next];
    next = (next + 1) % journeys().instants.size();
    prepare(instant);
    timings.measure([&] { work(instant); });
    state.SetIterationTime(timings.last() * 1e-6);
  }
  state.counters["median_us"] = timings.percentile(0.5);
  state.counters["p99_us"] = timings.percentile(0.99);
  state.counters["max_us"] = timings.percentile(1.0);
}

void kinematics(benchmark::State& state) {
  std::vector<Kinematics> arms;
  over_journeys(
      state, [](const Instant&) {}, [&](const Instant& instant) { journeys().place(instant, arms); });
}

void distances(benchmark::State& state) {
  ExactDistance distance(journeys().geometry);
  std::vector<Kinematics> arms;
  std::vector<Clearance> near(kMaxRows);
  double pairs = 0.0;
  double passes = 0.0;
  over_journeys(
      state, [&](const Instant& instant) { journeys().place(instant, arms); },
      [&](const Instant& instant) {
        pairs +=
            distance.clearances({arms.data(), arms, instant.obstacles}, {.others = kInfluence, .self = 0.15}, near);
        passes += 1.0;
      });
  state.counters["near_pairs"] = pairs / passes;
}

/// FCL objects for every body of the cell that FCL knows by a shape of its own.
std::shared_ptr<fcl::CollisionGeometryd> fcl_shape(const world::Shape& shape) {
  if (const auto* box = std::get_if<world::Box>(&shape)) {
    return std::make_shared<fcl::Boxd>(Eigen::Vector3d(2.0 * box->half_extents));
  }
  if (const auto* ball = std::get_if<world::Sphere>(&shape)) return std::make_shared<fcl::Sphered>(ball->radius);
  if (const auto* rod = std::get_if<world::Capsule>(&shape)) {
    return std::make_shared<fcl::Capsuled>(rod->radius, 2.0 * rod->half_length);
  }
  const auto& cylinder = std::get<world::Cylinder>(shape);
  return std::make_shared<fcl::Cylinderd>(cylinder.radius, 2.0 * cylinder.half_length);
}

void distances_fcl(benchmark::State& state) {
  const CellGeometry& geometry = journeys().geometry;
  ExactDistance distance(geometry);
  std::vector<Kinematics> arms;
  std::vector<Clearance> near(kMaxRows);
  std::vector<std::pair<fcl::CollisionObjectd, fcl::CollisionObjectd>> pairs;
  const auto object = [&](const Body& body, const Pose& X_WC) {
    return fcl::CollisionObjectd(fcl_shape(body.shape), X_WC * body.X_CS);
  };
  fcl::DistanceRequestd request;
  request.enable_nearest_points = true;
  over_journeys(
      state,
      [&](const Instant& instant) {
        journeys().place(instant, arms);
        const int count =
            distance.clearances({arms.data(), arms, instant.obstacles}, {.others = kInfluence, .self = 0.15}, near);
        pairs.clear();
        for (int k = 0; k < count; ++k) {
          const Clearance& c = near[k];
          const Body& own = geometry.own_bodies()[c.own_body];
          const bool obstacle = c.counterpart == Counterpart::kObstacle;
          const int arm = c.counterpart == Counterpart::kArm ? c.other : geometry.self();
          const Body& other =
              obstacle ? geometry.obstacle_bodies(c.other)[c.other_body] : geometry.arm_bodies(arm)[c.other_body];
          const Pose& X_WC = obstacle ? instant.obstacles[c.other].X_WO : arms[arm].X_WL[other.link];
          pairs.emplace_back(object(own, arms[0].X_WL[own.link]), object(other, X_WC));
        }
      },
      [&](const Instant&) {
        for (auto& [a, b] : pairs) {
          fcl::DistanceResultd result;
          benchmark::DoNotOptimize(fcl::distance(&a, &b, request, result));
        }
      });
}

/// Rows of the pairs near at an instant, as the tick builds them.
class RowBuilder {
 public:
  void prepare(const Instant& instant) {
    journeys().place(instant, arms_);
    count_ =
        distance_.clearances({arms_.data(), arms_, instant.obstacles}, {.others = kInfluence, .self = 0.15}, near_);
  }
  void build(const Instant& instant) {
    const DamperScene scene{journeys().geometry,
                            arms_[0],
                            arms_,
                            instant.arms,
                            instant.obstacles,
                            margins_,
                            journeys().cell.arms[0].parameters.damper};
    for (int k = 0; k < count_; ++k) rows_[k] = velocity_damper(scene, near_[k]);
  }
  [[nodiscard]] std::span<const Row> rows() const { return std::span(rows_).first(count_); }

 private:
  ExactDistance distance_{journeys().geometry};
  std::vector<Kinematics> arms_;
  std::vector<Clearance> near_{kMaxRows};
  std::array<double, 3> margins_{};
  std::array<Row, kMaxRows> rows_;
  int count_ = 0;
};

void rows(benchmark::State& state) {
  RowBuilder builder;
  over_journeys(
      state, [&](const Instant& i) { builder.prepare(i); }, [&](const Instant& i) { builder.build(i); });
}

void quadratic_programme(benchmark::State& state) {
  const JointLimits& limits = journeys().cell.arms[0].arm.limits;
  const double dt = journeys().cell.timing.control_period;
  RowBuilder builder;
  QpProblem problem;
  QpWarmStart warm;
  over_journeys(
      state,
      [&](const Instant& instant) {
        builder.prepare(instant);
        builder.build(instant);
        problem.rows = 0;
        const VelocityBounds bounds = speed_and_position_bounds(limits, instant.arms[0].q, dt);
        problem.lower = bounds.lower;
        problem.upper = bounds.upper;
        problem.target = goal_velocity(limits, instant.arms[0].q, instant.q_goal, dt);
        for (const Row& row : builder.rows()) problem.add_row(row.g, row.h, row.key);
      },
      [&](const Instant&) { benchmark::DoNotOptimize(solve(problem, warm).x); });
}

void whole_tick(benchmark::State& state) {
  const Cell& cell = journeys().cell;
  TickScratch scratch(journeys().geometry);
  TickMemory memory;
  TickInput input;
  input.dt = cell.timing.control_period;
  input.has_goal = true;
  over_journeys(
      state,
      [&](const Instant& instant) {
        input.q = instant.arms[0].q;
        input.qd = instant.arms[0].qd;
        input.q_goal = instant.q_goal;
        input.arms = instant.arms;
        input.obstacles = instant.obstacles;
      },
      [&](const Instant&) {
        benchmark::DoNotOptimize(tick(journeys().geometry, cell.arms[0].parameters, input, memory, scratch).q);
      });
}

BENCHMARK(kinematics)->Name("kinematics of three arms")->UseManualTime();
BENCHMARK(distances)->Name("distances, near pairs")->UseManualTime();
BENCHMARK(distances_fcl)->Name("distances, the same pairs by fcl::distance")->UseManualTime();
BENCHMARK(rows)->Name("rows of the near pairs")->UseManualTime();
BENCHMARK(quadratic_programme)->Name("quadratic programme")->UseManualTime();
BENCHMARK(whole_tick)->Name("whole tick")->UseManualTime();

}  // namespace

BENCHMARK_MAIN();
