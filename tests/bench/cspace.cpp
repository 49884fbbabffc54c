#include <string>

#include "planner/methods/sensed_cspace/obstacle_mapper.hpp"
#include "planner/methods/sensed_cspace/published/published_mapper.hpp"
#include "tests/bench/timings.hpp"
#include "tests/support/brute_force_cspace.hpp"

namespace hecaton::bench {
namespace {

using namespace planner::cspace;

constexpr int kObstacles = 10'000;
/// Growth of the widths for the rounding of both grids and half of the distance of boundary points [m].
constexpr double kInflation = 0.5;

/// Missed and falsely blocked cells of a mapper, compared with brute force.
class Account {
 public:
  void add(const CspaceMap& truth, const CspaceMap& map) {
    CspaceMap both = truth;
    both.block(map);
    const int true_cells = truth.blocked_cells();
    const int missed = both.blocked_cells() - map.blocked_cells();
    const int extra = both.blocked_cells() - true_cells;
    true_ += true_cells;
    missed_ += missed;
    extra_ += extra;
    with_missed_ += missed > 0 ? 1 : 0;
    if (true_cells > 0) worst_missed_ = std::max(worst_missed_, static_cast<double>(missed) / true_cells);
  }

  void report(benchmark::State& state, const std::string& name) const {
    state.counters[name + "missed_%"] = 100.0 * missed_ / true_;
    state.counters[name + "worst_%"] = 100.0 * worst_missed_;
    state.counters[name + "false_%"] = 100.0 * extra_ / true_;
    state.counters[name + "unsafe"] = with_missed_;
  }

 private:
  double true_ = 0.0, missed_ = 0.0, extra_ = 0.0, with_missed_ = 0.0, worst_missed_ = 0.0;
};

/// R4: random convex obstacles of the arm of [Li96]. Mappers: brute force (reference), as published, union of all
/// fundamental obstacles, union of exactly mapped border points (as sensors measure), and exact.
void cspace(benchmark::State& state) {
  const PlanarArm arm;
  const AngleGrid grid{360};
  const ImageDatabase images(arm, grid);
  const ImageDatabase inflated(arm.grown(kInflation), grid);
  const double build_us = time_once([&] { benchmark::DoNotOptimize(ImageDatabase(arm, grid)); });
  const test::BruteForce brute_force(arm, grid);
  ObstacleMapper mapper(arm, grid);
  ObstacleMapper point_mapper(arm.grown(kInflation), grid);
  planner::Random random(1996);
  ObstacleImage image;
  ObstacleImage published_image;
  CspaceMap exact_map(grid);
  CspaceMap published_map(grid);
  CspaceMap union_map(grid);
  CspaceMap points_map(grid);
  Timings exact, published, united, pointwise, brute;
  Account exact_account, published_account, union_account, points_account;
  for (auto _ : state) {
    const std::vector<Point> corners = test::random_convex(random, arm);
    const ConvexPiece piece = convex_piece(corners);
    const std::vector<FundamentalObstacle> obstacles = border(corners, images.spacing());
    CspaceMap truth(grid);
    brute.add(time_once([&] { truth = brute_force.map(corners); }));
    set_iteration_time(state, exact.measure([&] { exact_map.clear(); },
                                            [&] {
                                              mapper.map(piece, image);
                                              exact_map.block(image);
                                            }));
    published.measure([&] { published_map.clear(); },
                      [&] {
                        map_as_published(obstacles, find_critical_points(obstacles, images), images, published_image);
                        published_map.block(published_image);
                      });
    united.measure([&] { union_map.clear(); }, [&] { map_union(obstacles, inflated, union_map); });
    pointwise.measure([&] { points_map.clear(); },
                      [&] {
                        for (const Point& point : border_points(corners, 2.0 * kInflation)) {
                          point_mapper.map(convex_piece(std::span(&point, 1)), image);
                          points_map.block(image);
                        }
                      });
    exact_account.add(truth, exact_map);
    points_account.add(truth, points_map);
    published_account.add(truth, published_map);
    union_account.add(truth, union_map);
  }
  report(state, exact, brute);
  exact_account.report(state, "");
  state.counters["published_p50_us"] = published.percentile(0.5);
  state.counters["published_p99_us"] = published.percentile(0.99);
  published_account.report(state, "published_");
  state.counters["union_p50_us"] = united.percentile(0.5);
  state.counters["union_p99_us"] = united.percentile(0.99);
  union_account.report(state, "union_");
  state.counters["points_p50_us"] = pointwise.percentile(0.5);
  state.counters["points_p99_us"] = pointwise.percentile(0.99);
  points_account.report(state, "points_");
  state.counters["images"] = images.size();
  state.counters["images_build_us"] = build_us;
  state.counters["images_kB"] = static_cast<double>(images.bytes()) / 1e3;
}

BENCHMARK(cspace)
    ->Name("cspace/random_obstacles")
    ->Iterations(kObstacles)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
