/// hecaton-bench-plan: the global planner beside its peers, in one run. Apart from hecaton-bench, for it needs OMPL.

#include <cstdio>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/motionbenchmaker.hpp"
#include "tests/bench/run_benchmarks.hpp"

namespace {

constexpr const char* kUsage =
    R"(usage: hecaton-bench-plan [motionbenchmaker URDF SRDF PROBLEMS] [Google Benchmark's options]

Alone, or what --benchmark_filter=REGEX chooses of it:
  plan/      random configurations of a PUMA 560 among 21 boxes, and of three as one, beside FCL; the methods on random
             queries among 20 boxes, RRT-Connect beside OMPL's with FCL at the same step and with an explicit condition
             to end
  methods/   all methods, the potential fields too, on the same 200 queries
  nearest/   nearest points by a scan and by a tree
motionbenchmaker: RRT-Connect on the pairs of sceneNNNN.yaml and requestNNNN.yaml below PROBLEMS; `proven`: all edges
are free everywhere, `unproven`: at steps.
Times in microseconds of processor time. simplify: shortening; both, simplified: search and shortening; invalid: paths
in which FCL, at steps a tenth of the planner's, finds a collision; permissive: configurations called free that FCL
calls colliding.
Exit codes: 0 done, 2 usage or nothing selected, 3 bad input, 130 interrupted by Ctrl-C (143: by SIGTERM), with the rows
that are finished.

)";

}  // namespace

int main(int count, char** arguments) {
  std::vector<std::string> words(arguments, arguments + count);
  for (const std::string& word : words) {
    if (word == "-h" || word == "--help") std::fputs(kUsage, stdout);
  }
  if (words.size() > 1 && words[1] == "motionbenchmaker") {
    if (words.size() < 5) {
      std::fputs(kUsage, stderr);
      return 2;
    }
    try {
      hecaton::bench::register_motionbenchmaker(words[2], words[3], words[4]);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "hecaton-bench-plan: %s\n", error.what());
      return 3;
    }
    words.erase(words.begin() + 1, words.begin() + 5);
    words.insert(words.begin() + 1, "--benchmark_filter=^motionbenchmaker/");
  }
  words.insert(words.begin() + 1, "--benchmark_counters_tabular=true");
  return hecaton::bench::run_benchmarks(std::move(words));
}
