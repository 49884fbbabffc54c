#pragma once
/// Percentiles of timings over many pieces of work, and how one compares with another of the same run.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

namespace hecaton::bench {

class Timings {
 public:
  explicit Timings(std::string name) : name_(std::move(name)) {}

  /// Times one piece of work that gives the same every time: the fastest of three calls, so that percentiles tell how
  /// works differ, and not when another process had the processor.
  template <typename Work>
  void measure(const Work& work) {
    double fastest = std::numeric_limits<double>::infinity();
    for (int call = 0; call < 3; ++call) {
      const auto start = std::chrono::steady_clock::now();
      work();
      const auto end = std::chrono::steady_clock::now();
      fastest = std::min(fastest, std::chrono::duration<double, std::micro>(end - start).count());
    }
    microseconds_.push_back(fastest);
  }

  /// The value below which this fraction of all calls stayed [µs].
  [[nodiscard]] double percentile(double fraction) const {
    std::vector<double> sorted = microseconds_;
    std::sort(sorted.begin(), sorted.end());
    return sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1))];
  }

  /// The last call [µs].
  [[nodiscard]] double last() const { return microseconds_.back(); }

  void print() const {
    std::printf("%-58s %10.2f %10.2f %10.2f µs\n", name_.c_str(), percentile(0.5), percentile(0.99), percentile(1.0));
  }

  /// How many times longer `other` took.
  void print_ratio(const Timings& other) const {
    std::printf("  ratio %-50s %10.2f %10.2f\n", ("to " + other.name_).c_str(), other.percentile(0.5) / percentile(0.5),
                other.percentile(0.99) / percentile(0.99));
  }

  static void print_head() { std::printf("%-58s %10s %10s %10s\n", "", "median", "p99", "max"); }

 private:
  std::string name_;
  std::vector<double> microseconds_;
};

}  // namespace hecaton::bench
