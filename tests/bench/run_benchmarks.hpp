#pragma once
/// Runs Google Benchmark with progress on a terminal, and keeps the finished rows when a signal ends the run.

#include <string>
#include <vector>

namespace hecaton::bench {

/// Runs what `words`, a command line of Google Benchmark, selects. Prints each row when it is finished. JSON output has
/// the member `interrupted`. Returns the exit code: 0 done; 2 usage, or nothing selected; 130 or 143 after a signal.
[[nodiscard]] int run_benchmarks(std::vector<std::string> words);

/// Benchmarks call this between pieces of their work, outside what they time. Shows the progress of the present row. A
/// signal makes it throw an exception that run_benchmarks() catches.
void show_progress(double done, double all, const std::string& unit);

}  // namespace hecaton::bench
