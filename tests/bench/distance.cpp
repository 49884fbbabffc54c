#include <algorithm>
#include <cmath>
#include <cstdio>

#include "planner/collision/exact_distance.hpp"
#include "tests/bench/benches.hpp"
#include "tests/bench/pairs_cell.hpp"

namespace hecaton::bench {
namespace {

constexpr int kInstants = 2000;
constexpr double kInfluence = 0.12;    // [m]
constexpr double kEverything = 100.0;  // [m]

/// How often and how far FCL is off; its answers for overlapping pairs are no distances.
struct Disagreement {
  long differing = 0;
  double most_above = 0.0;
  double most_below = 0.0;

  void compare(const std::vector<planner::Clearance>& ours, const std::vector<double>& theirs) {
    for (std::size_t k = 0; k < theirs.size(); ++k) {
      if (theirs[k] <= 0.0 || ours[k].distance <= 0.0) continue;
      const double difference = theirs[k] - ours[k].distance;
      differing += std::abs(difference) > 1e-4 ? 1 : 0;
      most_above = std::max(most_above, difference);
      most_below = std::max(most_below, -difference);
    }
  }
};

}  // namespace

void run_distance(Output output) {
  PairsCell cell(20060521);
  planner::ExactDistance distance(cell.geometry());
  FclPairs fcl(cell.geometry());
  std::vector<planner::Clearance> room(kPairs);
  std::vector<double> theirs;
  Timings near_pass("Hecaton, pairs within 0.12 m (a tick's pass)");
  Timings full_pass("Hecaton, all 192 pairs");
  Timings fcl_pass("fcl::distance, all 192 pairs, nearest points");
  Disagreement disagreement;
  long near = 0;
  for (int i = 0; i < kInstants; ++i) {
    const Instant instant = cell.draw();
    const planner::CellPoses poses{instant.kinematics.data(), instant.kinematics, instant.obstacles};
    int count = 0;
    near_pass.measure([&] { count = distance.clearances(poses, {kInfluence, 0.0, {}}, room); });
    near += count;
    full_pass.measure([&] { count = distance.clearances(poses, {kEverything, 0.0, {}}, room); });
    fcl_pass.measure([&] { fcl.distances(instant, theirs); });
    disagreement.compare(room, theirs);
  }
  print(output, {{near_pass, &fcl_pass}, {full_pass, &fcl_pass}, {readings_of_the_clock(), nullptr}});
  std::fprintf(stderr, "pairs within %.2f m: %.1f a pass\n", kInfluence, static_cast<double>(near) / kInstants);
  std::fprintf(stderr, "FCL differs by more than 0.1 mm on %ld of %d pairs; at most %.2g m above ours, %.2g m below\n",
               disagreement.differing, kPairs * kInstants, disagreement.most_above, disagreement.most_below);
}

}  // namespace hecaton::bench
