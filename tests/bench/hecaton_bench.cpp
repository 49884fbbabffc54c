/// hecaton-bench: timings of Hecaton and its peers in one run. Google Benchmark's command line, and a short form of it:
/// `hecaton-bench tick` is `--benchmark_filter=^(tick)/ --benchmark_counters_tabular=true`.

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/run_benchmarks.hpp"

namespace {

constexpr const char* kUsage =
    "usage: hecaton-bench [tick|distance|growth|rollouts|routes|points|cspace|wire|world|strategies …] [Google "
    "Benchmark's options]\n"
    "\n"
    "  tick      one control period of an arm, 192 pairs of bodies, and where its time goes\n"
    "  distance  its distance pass alone, beside FCL's pairwise distances\n"
    "  growth    ticks of generated cells of 3, 10, 30 and 100 arms\n"
    "  rollouts  ticks a second of rollouts of three arms\n"
    "  routes    routes of a blocked arm around everything at its present pose, at three levels of clearance\n"
    "  points    configurations, edges and ticks of an arm among 1,000 to 100,000 points on 20 boxes; the peer is the "
    "same\n"
    "            arm among the boxes; brute_ratio: all balls, one by one, to ours\n"
    "  cspace    10,000 obstacles mapped into the C-space of a planar arm: cost, and cells missed and false\n"
    "  wire      the check of 100 received arm states against their limits; the peer is their decoding\n"
    "  world     steps, scans and edits of the world of three moving arms among 100, 1,000 and 10,000 obstacles; the "
    "peer\n"
    "            checks each pair with a moving part, or casts each ray at each obstacle; processor time\n"
    "  strategies  the grid of motion strategies of scorbot_2a: 576 in 300 tasks, the faultless in 2 x 1800; p50, p99\n"
    "            and max are over strategies (of the last set), tick_us is an arm's mean step, fcl_us what FCL's\n"
    "            distances of one arm cost for such a step; one core\n"
    "\n"
    "Times are in microseconds: Time is the mean, p50, p99 and max are over inputs, each the fastest of three\n"
    "calls on the same input, first_p50 and first_p99 of the first of them, with cold caches (growth/all_on_one_core: "
    "a period's mean, rollouts: the mean of one rollout, once). The peer\n"
    "(fcl::distance with nearest points, all pairs of an arm's bodies with the others': 192 here, with growth 36 for\n"
    "each other arm) is timed in turns with ours; ratio is that of the medians, tree_ratio that of FCL's tree of\n"
    "boxes, asked for pairs within 0.12 m. Every figure includes two readings of the clock (benchmark `tick/clock`).\n"
    "rows: constraints a tick; core_use: of one core, by all arms at 500 Hz; ticks_per_s: on one core. That a library\n"
    "was built as DEBUG is said of Google Benchmark's package, not of ours.\n"
    "JSON: --benchmark_format=json. Exit codes: 0 done, 2 usage or nothing selected, 130 interrupted by\n"
    "Ctrl-C (143: by SIGTERM), with the rows that are finished.\n\n";

bool is_group(const std::string& word) {
  return word == "tick" || word == "distance" || word == "growth" || word == "rollouts" || word == "routes" ||
         word == "points" || word == "cspace" || word == "wire" || word == "world" || word == "strategies";
}

}  // namespace

int main(int count, char** arguments) {
  std::vector<std::string> words(arguments, arguments + count);
  std::string groups;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i] == "-h" || words[i] == "--help") std::fputs(kUsage, stdout);
    if (words[i].starts_with("-")) continue;
    if (!is_group(words[i])) {
      std::fprintf(stderr,
                   "hecaton-bench: '%s' must be tick, distance, growth, rollouts, routes, points, cspace, wire, world "
                   "or strategies\n%s",
                   words[i].c_str(), kUsage);
      return 2;
    }
    groups += (groups.empty() ? "" : "|") + words[i];
  }
  std::erase_if(words, [](const std::string& word) { return is_group(word); });
  words.insert(words.begin() + 1, "--benchmark_counters_tabular=true");
  if (!groups.empty()) words.insert(words.begin() + 1, "--benchmark_filter=^(" + groups + ")/");
  return hecaton::bench::run_benchmarks(std::move(words));
}
