/// The global planner: what a configuration, and what a path costs.

#include "planner/global/plan.hpp"

#include <string>

#include "tests/bench/ompl_peer.hpp"
#include "tests/bench/query_set.hpp"
#include "tests/bench/timings.hpp"
#include "tests/support/puma_among_boxes.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;
using Configuration = std::vector<double>;

constexpr int kFiner = 10;  ///< FCL looks at paths so many times as finely as the planners do

/// Eight random configurations at a time, against each of them by FCL: the costs of one are an eighth.
void measure_states(benchmark::State& state, const Validity& validity, std::span<const WorldBody> world) {
  test::FclCollisionChecker checker(validity, world);
  const Configuration zero(validity.dimensions(), 0.0);
  const Space space = space_of(validity, zero, zero);
  Random random(2);
  constexpr int kBatch = 64;  // blocks, so that reading the clock does not count
  std::vector<float> states(static_cast<std::size_t>(kBatch) * kWidth * space.stride);
  Timings ours;
  Timings peer;
  double free = 0.0;
  double permissive = 0.0;
  double all = 0.0;
  for (auto _ : state) {
    for (int i = 0; i < kBatch * kWidth; ++i) space.sample(random, states.data() + i * space.stride);
    const auto block = [&](int i) { return states.data() + static_cast<std::ptrdiff_t>(i) * kWidth * space.stride; };
    const double us = processor_time_once([&] {
      for (int i = 0; i < kBatch; ++i) benchmark::DoNotOptimize(validity.collisions(block(i)));
    });
    ours.add(us / (kBatch * kWidth));
    set_iteration_time(state, us / (kBatch * kWidth));
    const unsigned collisions = validity.collisions(block(0));
    unsigned fcl = 0;
    peer.add(processor_time_once([&] {
               for (int lane = 0; lane < kWidth; ++lane) {
                 fcl |= checker.collides(block(0) + lane * space.stride) ? 1U << lane : 0U;
               }
             }) /
             kWidth);
    free += kWidth - __builtin_popcount(collisions);
    permissive += __builtin_popcount(fcl & ~collisions);
    all += kWidth;
  }
  report(state, ours, peer);
  state.counters["free_%"] = 100.0 * free / all;
  state.counters["permissive"] = permissive;
}

/// P3: a PUMA 560, itself and 21 boxes.
void one_arm(benchmark::State& state) {
  Random random(1);
  const auto world = test::random_boxes(21, random);
  measure_states(state, Validity({CellGeometry({test::puma()}, 0)}, world), world);
}

/// P7: three of them as one, and six boxes.
void three_arms(benchmark::State& state) {
  std::vector<Arm> arms{test::puma("a"), test::puma("b"), test::puma("c")};
  arms[1].X_WB.translation() = Eigen::Vector3d(0.9, 0.0, 0.0);
  arms[2].X_WB.translation() = Eigen::Vector3d(0.4, 0.8, 0.0);
  Random random(1);
  const auto world = test::random_boxes(6, random);
  measure_states(state, Validity({CellGeometry(arms, 0), CellGeometry(arms, 1), CellGeometry(arms, 2)}, world), world);
}

/// P4: random starts and goals of a PUMA 560 among 20 boxes that the straight way does not join.
void puma_among_boxes(benchmark::State& state, const std::string& method) {
  const bool beside_peer = method == "rrt_connect";
  Timings ours;
  Timings simplified;
  Timings peer;
  Random random(4);
  double solved = 0.0;
  double solved_by_peer = 0.0;
  double invalid = 0.0;
  for (auto _ : state) {
    const auto world = test::random_boxes(20, random);
    ValidityOptions options;
    options.step = 0.031;
    const Validity validity({CellGeometry({test::puma()}, 0)}, world, options);
    test::FclCollisionChecker checker(validity, world);
    Configuration start;
    Configuration goal;
    do {
      start = draw_free(validity, checker, random);
      goal = draw_free(validity, checker, random);
    } while (checker.collisions_on({start, goal}, options.step) == 0 || !path_exists(validity, checker, start, goal));
    PlanOptions plan_options;
    plan_options.planner = built_in_planners().at(method);
    plan_options.simplify = false;
    plan_options.budget.ended = processor_deadline(kLongestSearch);
    Plan found;
    const double us = processor_time_once([&] { found = plan(validity, start, goal, plan_options); });
    ours.add(us);
    set_iteration_time(state, us);
    solved += found.solved() ? 1.0 : 0.0;
    plan_options.budget.ended = processor_deadline(kLongestSearch);
    simplified.add(processor_time_once([&] {
      found = plan(validity, start, goal, plan_options);
      simplify(validity, plan_options, found);
    }));
    invalid += checker.collisions_on(found.path, options.step / kFiner) > 0 ? 1.0 : 0.0;
    if (!beside_peer) continue;
    OmplPlan of_peer;
    peer.add(processor_time_once([&] { of_peer = plan_with_ompl(validity, checker, start, goal, kLongestSearch); }));
    solved_by_peer += of_peer.solved ? 1.0 : 0.0;
  }
  state.counters["solved"] = solved;
  state.counters["invalid"] = invalid;
  state.counters["p95"] = ours.percentile(0.95);
  state.counters["simplified_p50"] = simplified.percentile(0.5);
  if (beside_peer) {
    report(state, ours, peer);
    state.counters["peer_solved"] = solved_by_peer;
    state.counters["peer_p95"] = peer.percentile(0.95);
    state.counters["ratio_p95"] = peer.percentile(0.95) / ours.percentile(0.95);
  } else {
    report(state, ours);
  }
}

BENCHMARK(one_arm)->Name("plan/state_of_one_arm")->Iterations(1000)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(three_arms)
    ->Name("plan/state_of_three_arms")
    ->Iterations(500)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(puma_among_boxes, rrt_connect, "rrt_connect")
    ->Name("plan/puma_among_boxes/rrt_connect")
    ->Iterations(125)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(puma_among_boxes, rrt, "rrt")
    ->Name("plan/puma_among_boxes/rrt")
    ->Iterations(125)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(puma_among_boxes, est, "est")
    ->Name("plan/puma_among_boxes/est")
    ->Iterations(125)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(puma_among_boxes, prm, "prm")
    ->Name("plan/puma_among_boxes/prm")
    ->Iterations(125)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
