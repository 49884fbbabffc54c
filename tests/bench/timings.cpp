#include "tests/bench/timings.hpp"

#include <cmath>
#include <numeric>

namespace hecaton::bench {

namespace {

double percentile_of(std::vector<double> all, double fraction) {
  if (all.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(all.begin(), all.end());
  return all[static_cast<std::size_t>(fraction * static_cast<double>(all.size() - 1))];
}

}  // namespace

double Timings::percentile(double fraction) const {
  return percentile_of(microseconds_, fraction);
}

double Timings::first_percentile(double fraction) const {
  return percentile_of(first_, fraction);
}

double Timings::total() const {
  return std::accumulate(microseconds_.begin(), microseconds_.end(), 0.0);
}

void report(benchmark::State& state, const Timings& ours) {
  state.counters["p50_us"] = ours.percentile(0.5);
  state.counters["p99_us"] = ours.percentile(0.99);
  state.counters["max_us"] = ours.percentile(1.0);
  const double first = ours.first_percentile(0.5);
  if (std::isnan(first)) return;
  state.counters["first_p50_us"] = first;
  state.counters["first_p99_us"] = ours.first_percentile(0.99);
}

void report(benchmark::State& state, const Timings& ours, const Timings& peer) {
  report(state, ours);
  state.counters["peer_p50_us"] = peer.percentile(0.5);
  state.counters["peer_p99_us"] = peer.percentile(0.99);
  state.counters["ratio"] = peer.percentile(0.5) / ours.percentile(0.5);
}

}  // namespace hecaton::bench
