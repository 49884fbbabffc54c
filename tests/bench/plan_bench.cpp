/// hecaton-bench-plan: the global planner beside its peers, in one run. Apart from hecaton-bench, for it needs OMPL.

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/motionbenchmaker.hpp"
#include "tests/bench/run_benchmarks.hpp"

namespace {

constexpr const char* kUsage =
    R"(usage: hecaton-bench-plan [Google Benchmark's options]
       hecaton-bench-plan motionbenchmaker URDF SRDF PROBLEMS [options]   (--help explains them)

Without motionbenchmaker, or what --benchmark_filter=REGEX chooses of it:
  plan/      random configurations of a PUMA 560 among 21 boxes, and of three as one, beside FCL; the methods on random
             queries among 20 boxes, RRT-Connect beside OMPL's with FCL at the same step and with an explicit condition
             to end
  methods/   all methods, the potential fields too, on the same 200 queries
  nearest/   nearest points by a scan and by a tree
Times in microseconds of processor time. simplified: search and shortening; invalid: paths
in which FCL, at steps a tenth of the planner's, finds a collision; permissive: configurations called free that FCL
calls colliding.
Exit codes: 0 done, 2 usage or nothing selected, 130 interrupted by Ctrl-C (143: by SIGTERM), with the rows
that are finished.

)";

}  // namespace

int main(int count, char** arguments) {
  if (count > 1 && std::string(arguments[1]) == "motionbenchmaker") {
    return hecaton::bench::run_motionbenchmaker(count - 1, arguments + 1);
  }
  std::vector<std::string> words(arguments, arguments + count);
  for (const std::string& word : words) {
    if (word == "-h" || word == "--help") std::fputs(kUsage, stdout);
  }
  words.insert(words.begin() + 1, "--benchmark_counters_tabular=true");
  return hecaton::bench::run_benchmarks(std::move(words));
}
