/// hecaton-bench: how fast, beside the peers, in one run.

#include <cstdio>
#include <cstring>
#include <string>

#include "tests/bench/benches.hpp"

namespace {

using hecaton::bench::Output;

constexpr const char* kUsage =
    "usage: hecaton-bench tick|distance|growth|plays [-o table|json]\n"
    "\n"
    "  tick      one control period of an arm, 192 pairs of bodies, and where its time goes\n"
    "  distance  its distance pass alone, beside FCL's pairwise distances\n"
    "  growth    ticks of generated cells of 3, 10, 30 and 100 arms\n"
    "  plays     ticks a second when cells are played forward, as in rollouts\n"
    "\n"
    "Each figure is the fastest of three calls on the same input; median, 99th percentile and maximum are over "
    "inputs.\n"
    "The peer is timed alternately with ours. Exit codes: 0 done, 2 usage.\n";

int usage_error(const std::string& complaint) {
  std::fprintf(stderr, "hecaton-bench: %s\n%s", complaint.c_str(), kUsage);
  return 2;
}

}  // namespace

int main(int count, char** arguments) {
  std::string what;
  Output output = Output::kTable;
  for (int i = 1; i < count; ++i) {
    const std::string word = arguments[i];
    if (word == "-h" || word == "--help") {
      std::fputs(kUsage, stdout);
      return 0;
    }
    if (word == "-o" || word == "--output") {
      const std::string format = ++i < count ? arguments[i] : "";
      if (format != "table" && format != "json") return usage_error(word + " must be table or json");
      output = format == "json" ? Output::kJson : Output::kTable;
    } else if (what.empty()) {
      what = word;
    } else {
      return usage_error("'" + word + "' is one argument too many");
    }
  }
  if (what == "tick") {
    hecaton::bench::run_tick(output);
  } else if (what == "distance") {
    hecaton::bench::run_distance(output);
  } else if (what == "growth") {
    hecaton::bench::run_growth(output);
  } else if (what == "plays") {
    hecaton::bench::run_plays(output);
  } else {
    return usage_error(what.empty() ? "say what to measure" : "'" + what + "' must be tick, distance, growth or plays");
  }
  return 0;
}
