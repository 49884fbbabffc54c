#include "tests/bench/timings.hpp"

#include <numeric>

namespace hecaton::bench {

double Timings::percentile(double fraction) const {
  if (microseconds_.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted = microseconds_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1))];
}

double Timings::total() const {
  return std::accumulate(microseconds_.begin(), microseconds_.end(), 0.0);
}

void set_iteration_time(benchmark::State& state, double microseconds) {
  state.SetIterationTime(microseconds * 1e-6);
}

void report(benchmark::State& state, const Timings& ours) {
  state.counters["p50_us"] = ours.percentile(0.5);
  state.counters["p99_us"] = ours.percentile(0.99);
  state.counters["max_us"] = ours.percentile(1.0);
}

void report(benchmark::State& state, const Timings& ours, const Timings& peer) {
  report(state, ours);
  state.counters["peer_p50_us"] = peer.percentile(0.5);
  state.counters["peer_p99_us"] = peer.percentile(0.99);
  state.counters["ratio"] = peer.percentile(0.5) / ours.percentile(0.5);
}

}  // namespace hecaton::bench
