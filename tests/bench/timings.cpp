#include "tests/bench/timings.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

namespace hecaton::bench {
namespace {

using Json = nlohmann::ordered_json;

/// Three decimals: the clock tells no more.
double rounded(double microseconds) {
  return std::round(microseconds * 1000.0) / 1000.0;
}

Json to_json(const Row& row) {
  Json json = {{"name", row.ours.name()},
               {"median_us", rounded(row.ours.percentile(0.5))},
               {"p99_us", rounded(row.ours.percentile(0.99))},
               {"max_us", rounded(row.ours.percentile(1.0))}};
  if (row.peer != nullptr) {
    json["peer"] = {{"name", row.peer->name()},
                    {"median_us", rounded(row.peer->percentile(0.5))},
                    {"p99_us", rounded(row.peer->percentile(0.99))}};
    json["ratio"] = rounded(row.peer->percentile(0.5) / row.ours.percentile(0.5));
  }
  return json;
}

void print_line(const Timings& timings, double ratio) {
  std::printf("%-64s %9.3f %9.3f %9.3f", timings.name().c_str(), timings.percentile(0.5), timings.percentile(0.99),
              timings.percentile(1.0));
  std::printf(ratio > 0.0 ? " %9.1f\n" : "\n", ratio);
}

}  // namespace

double Timings::percentile(double fraction) const {
  std::vector<double> sorted = microseconds_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<std::size_t>(fraction * static_cast<double>(sorted.size() - 1))];
}

Timings readings_of_the_clock() {
  Timings timings("two readings of the clock, in every figure");
  for (int i = 0; i < 1000; ++i) timings.measure([] {});
  return timings;
}

void print(Output output, const std::vector<Row>& rows) {
  if (output == Output::kJson) {
    for (const Row& row : rows) std::printf("%s\n", to_json(row).dump().c_str());
    return;
  }
  std::printf("%-64s %9s %9s %9s %9s\n", "[µs]", "median", "p99", "max", "ratio");
  std::vector<const Timings*> peers;
  for (const Row& row : rows) {
    const double ratio = row.peer == nullptr ? 0.0 : row.peer->percentile(0.5) / row.ours.percentile(0.5);
    print_line(row.ours, ratio);
    if (row.peer != nullptr && std::find(peers.begin(), peers.end(), row.peer) == peers.end()) {
      peers.push_back(row.peer);
    }
  }
  for (const Timings* peer : peers) print_line(*peer, 0.0);
}

}  // namespace hecaton::bench
