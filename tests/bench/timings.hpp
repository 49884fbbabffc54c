#pragma once
/// Percentiles of timings over many pieces of work, and how one compares with a peer's of the same run.

#include <chrono>
#include <limits>
#include <string>
#include <vector>

namespace hecaton::bench {

class Timings {
 public:
  explicit Timings(std::string name) : name_(std::move(name)) {}

  /// Times one piece of work: the fastest of three calls, so that percentiles tell how works differ, and not when
  /// another process had the processor. `prepare` runs untimed before each call and makes all three the same.
  template <typename Prepare, typename Work>
  void measure(const Prepare& prepare, const Work& work) {
    double fastest = std::numeric_limits<double>::infinity();
    for (int call = 0; call < 3; ++call) {
      prepare();
      const auto start = std::chrono::steady_clock::now();
      work();
      const auto end = std::chrono::steady_clock::now();
      fastest = std::min(fastest, std::chrono::duration<double, std::micro>(end - start).count());
    }
    add(fastest);
  }
  /// The same for work that gives the same every time.
  template <typename Work>
  void measure(const Work& work) {
    measure([] {}, work);
  }
  void add(double microseconds) { microseconds_.push_back(microseconds); }

  /// The value below which this fraction of all calls stayed [µs].
  [[nodiscard]] double percentile(double fraction) const;
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::vector<double> microseconds_;
};

/// What timing costs and every figure includes: two readings of the clock.
[[nodiscard]] Timings readings_of_the_clock();

/// One line of a report: ours, and the peer that was timed alternately with it, if there is one.
struct Row {
  Timings ours;
  const Timings* peer = nullptr;
};

enum class Output { kTable, kJson };

/// {"name":…,"median_us":…,"p99_us":…,"max_us":…,"peer":{"name":…,"median_us":…,"p99_us":…},"ratio":…} a line, or a
/// table. The ratio is that of the medians: how many times longer the peer took.
void print(Output output, const std::vector<Row>& rows);

}  // namespace hecaton::bench
