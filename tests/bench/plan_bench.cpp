/// hecaton-bench-plan: the global planner beside its peers, in one run. Apart from hecaton-bench, for it needs OMPL.

#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "tests/bench/motionbenchmaker.hpp"
#include "tests/bench/timings.hpp"

namespace {

constexpr const char* kUsage =
    "usage: hecaton-bench-plan [motionbenchmaker URDF SRDF PROBLEMS] [Google Benchmark's options]\n"
    "\n"
    "Alone: random configurations of a PUMA 560 among 21 boxes, and of three as one, beside FCL; the methods on "
    "random\n"
    "queries among 20 boxes, RRT-Connect beside OMPL's with FCL at the same step and with an explicit condition to "
    "end.\n"
    "motionbenchmaker: RRT-Connect on the pairs of sceneNNNN.yaml and requestNNNN.yaml below PROBLEMS; `certified`:\n"
    "paths looked at ten times as finely, and planned anew where that finds something.\n"
    "Times in microseconds; simplified: search and shortening; invalid: paths in which FCL, at steps a tenth of the\n"
    "planner's, finds a collision; permissive: configurations called free that FCL calls colliding.\n"
    "Exit codes: 0 done, 2 usage, 3 bad input.\n\n";

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
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  int left = static_cast<int>(pointers.size());
  benchmark::Initialize(&left, pointers.data());
  if (benchmark::ReportUnrecognizedArguments(left, pointers.data())) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
