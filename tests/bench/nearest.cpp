/// The nearest of many points by a SIMD scan and by a tree, to find the number of points from which the tree is faster.

#include <string>
#include <vector>

#include "planner/global/nearest_points.hpp"
#include "planner/local/random.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using namespace planner;
using namespace planner::global;

constexpr int kQueries = 200;
/// As many as PRM joins a node with, and as far as EST looks around one.
constexpr int kFew = 10;
constexpr float kAround = 1.0F;

/// Points and queries all over a box: as samples of a search are.
void scan_beside_tree(benchmark::State& state) {
  const auto points = static_cast<int>(state.range(0));
  const auto dimensions = static_cast<int>(state.range(1));
  Random random(1);
  std::vector<float> q(dimensions);
  const auto draw = [&] {
    for (float& x : q) x = static_cast<float>(random.uniform(-3.0, 3.0));
    return q.data();
  };
  PointGroups all(dimensions);
  KdTree tree(dimensions);
  const double scan_adds = processor_time_once([&] {
    for (int i = 0; i < points; ++i) all.add(draw());
  });
  random = Random(1);
  const double tree_adds = processor_time_once([&] {
    for (int i = 0; i < points; ++i) tree.add(draw());
  });
  Timings scanned, found, scanned_few, found_few, scanned_around, found_around;
  std::vector<Neighbour> near;
  for (auto _ : state) {
    for (int i = 0; i < kQueries; ++i) {
      draw();
      scanned.add(processor_time_once([&] { benchmark::DoNotOptimize(all.nearest(q.data())); }));
      found.add(processor_time_once([&] { benchmark::DoNotOptimize(tree.nearest(q.data())); }));
      scanned_few.add(processor_time_once([&] { all.nearest(q.data(), kFew, near); }));
      found_few.add(processor_time_once([&] { tree.nearest(q.data(), kFew, near); }));
      scanned_around.add(processor_time_once([&] { all.within(q.data(), kAround, near); }));
      found_around.add(processor_time_once([&] { tree.within(q.data(), kAround, near); }));
    }
    set_iteration_time(state, scanned.total());
  }
  state.counters["scan_p50_us"] = scanned.percentile(0.5);
  state.counters["tree_p50_us"] = found.percentile(0.5);
  state.counters["scan_few_us"] = scanned_few.percentile(0.5);
  state.counters["tree_few_us"] = found_few.percentile(0.5);
  state.counters["scan_around_us"] = scanned_around.percentile(0.5);
  state.counters["tree_around_us"] = found_around.percentile(0.5);
  state.counters["scan_mean_us"] = scanned.total() / kQueries;
  state.counters["tree_mean_us"] = found.total() / kQueries;
  state.counters["tree_add_us"] = (tree_adds - scan_adds) / points;
}

BENCHMARK(scan_beside_tree)
    ->Name("nearest/scan_and_tree")
    ->ArgNames({"points", "dimensions"})
    ->ArgsProduct({{256, 1000, 4000, 10'000, 30'000, 100'000}, {2, 3, 6, 7, 9, 12, 18}})
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
