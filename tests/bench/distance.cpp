#include <cmath>

#include "planner/collision/exact_distance.hpp"
#include "tests/bench/fcl_peer.hpp"
#include "tests/bench/pairs_cell.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

constexpr int kInstants = 2000;
constexpr double kInfluence = 0.12;    // a tick's pass [m]
constexpr double kEverything = 100.0;  // [m]

/// Number and size of FCL's errors, without overlapping pairs, for which FCL returns no distances.
class Disagreement {
 public:
  void compare(const std::vector<planner::Clearance>& ours, const std::vector<double>& theirs) {
    for (std::size_t k = 0; k < theirs.size(); ++k) {
      if (theirs[k] <= 0.0 || ours[k].distance <= 0.0) continue;
      const double difference = theirs[k] - ours[k].distance;
      differing_ += std::abs(difference) > 1e-4 ? 1 : 0;
      most_above_ = std::max(most_above_, difference);
      most_below_ = std::max(most_below_, -difference);
    }
  }

  void report(benchmark::State& state) const {
    state.counters["fcl_off_by_0.1mm"] = benchmark::Counter(differing_, benchmark::Counter::kAvgIterations);
    state.counters["fcl_above_mm"] = most_above_ * 1e3;
    state.counters["fcl_below_mm"] = most_below_ * 1e3;
  }

 private:
  double differing_ = 0.0;
  double most_above_ = 0.0;
  double most_below_ = 0.0;
};

/// The distance pass at random instants of the cell, compared with FCL on the same pairs.
void distance(benchmark::State& state, double influence) {
  PairsCell cell(20060521);
  planner::ExactDistance distance(cell.geometry());
  FclPeer fcl(cell.geometry());
  std::vector<planner::Clearance> room(kPairs);
  std::vector<double> theirs;
  Timings ours;
  Timings peer;
  Disagreement disagreement;
  double near = 0.0;
  for (auto _ : state) {
    const Instant instant = cell.draw();
    const planner::CellPoses poses{instant.kinematics.data(), instant.kinematics, instant.obstacles};
    int count = 0;
    set_iteration_time(state, ours.measure([&] { count = distance.clearances(poses, {influence, 0.0, {}}, room); }));
    peer.measure([&] { fcl.distances(0, instant, theirs); });
    near += count;
    if (count == kPairs) disagreement.compare(room, theirs);
  }
  report(state, ours, peer);
  state.counters["pairs"] = benchmark::Counter(near, benchmark::Counter::kAvgIterations);
  if (influence == kEverything) disagreement.report(state);
}

BENCHMARK_CAPTURE(distance, within_0 .12_m, kInfluence)
    ->Iterations(kInstants)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(distance, all_pairs, kEverything)
    ->Iterations(kInstants)
    ->UseManualTime()
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace hecaton::bench
