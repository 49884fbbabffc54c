#pragma once
/// Percentiles of timings over many inputs, compared with a peer's in the same run. Google Benchmark prints means only;
/// a control loop needs the median and p99.

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>
#include <vector>

#include <benchmark/benchmark.h>

namespace hecaton::bench {

/// Wall time of one call of `work` [µs].
template <typename Work>
double time_once(const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count();
}

/// Processor time of this thread for one call of `work` [µs].
template <typename Work>
double processor_time_once(const Work& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return 1e6 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

class Timings {
 public:
  /// Times one piece of work: the fastest of three calls, so that percentiles tell how works differ, and not when
  /// another process had the processor. `prepare` runs untimed before each call and makes all three the same. The
  /// first call, for which caches and branch predictors are as other work left them, is kept apart as well. [µs]
  template <typename Prepare, typename Work>
  double measure(const Prepare& prepare, const Work& work) {
    double fastest = std::numeric_limits<double>::infinity();
    for (int call = 0; call < 3; ++call) {
      prepare();
      const double taken = time_once(work);
      if (call == 0) first_.push_back(taken);
      fastest = std::min(fastest, taken);
    }
    add(fastest);
    return fastest;
  }
  /// The same for work without preparation.
  template <typename Work>
  double measure(const Work& work) {
    return measure([] {}, work);
  }
  void add(double microseconds) { microseconds_.push_back(microseconds); }

  /// The value below which this fraction of all calls stayed [µs]; NaN before the first.
  [[nodiscard]] double percentile(double fraction) const;
  /// The same of first calls.
  [[nodiscard]] double first_percentile(double fraction) const;
  [[nodiscard]] double total() const;

 private:
  std::vector<double> microseconds_;
  std::vector<double> first_;
};

/// Google Benchmark's time of this iteration; its benchmarks are registered with UseManualTime. Shows the progress of
/// rows with several iterations, and throws after a signal, as show_progress() (tests/bench/run_benchmarks.hpp).
void set_iteration_time(benchmark::State& state, double microseconds);

/// The columns p50, p99 and max [µs] of a benchmark, and p50 and p99 of first calls.
void report(benchmark::State& state, const Timings& ours);
/// And the peer's, timed in turns with ours: how many times longer it took, by the medians.
void report(benchmark::State& state, const Timings& ours, const Timings& peer);

}  // namespace hecaton::bench
