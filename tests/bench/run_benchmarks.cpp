#include "tests/bench/run_benchmarks.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <sstream>

#include <benchmark/benchmark.h>

#include "services/command_line/long_work.hpp"
#include "tests/bench/timings.hpp"

namespace hecaton::bench {
namespace {

using services::cli::Interrupted;
using services::cli::Interruption;
using services::cli::Progress;

/// Unwinds a benchmark after a signal.
struct SignalReceived {};

/// The run of this process, between the beginning and the end of run_benchmarks().
struct Run {
  Interruption interruption;
  Progress progress;
  std::size_t asked = 0;  ///< rows
  std::size_t rows = 0;   ///< finished
  double iterations = 0;  ///< of the present row
};
std::unique_ptr<Run> run;

/// Google Benchmark's reporter; clears the progress before each row and completes the JSON document.
class Reporter : public benchmark::BenchmarkReporter {
 public:
  explicit Reporter(bool json) : inner_(benchmark::CreateDefaultDisplayReporter()), json_(json) {}

  bool ReportContext(const Context& context) override { return inner_->ReportContext(context); }
  void ReportRuns(const std::vector<benchmark::BenchmarkReporter::Run>& runs) override {
    run->progress.clear();
    run->iterations = 0;
    inner_->ReportRuns(runs);
    ++run->rows;
  }
  void Finalize() override {
    if (!json_) inner_->Finalize();
  }
  void end(const std::optional<Interrupted>& interrupted) {
    if (json_) {
      GetOutputStream() << "\n  ],\n  \"interrupted\": " << services::cli::to_json(interrupted).dump() << "\n}\n";
    } else if (interrupted) {
      GetOutputStream() << interrupted->text() << '\n';
    }
    GetOutputStream().flush();
  }

 private:
  benchmark::BenchmarkReporter* inner_;  ///< of the library
  bool json_;
};

/// Applies the options. False: one is unknown.
bool initialize(std::vector<std::string> words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  int left = static_cast<int>(pointers.size());
  benchmark::Initialize(&left, pointers.data());
  return !benchmark::ReportUnrecognizedArguments(left, pointers.data());
}

bool has(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The number of rows that the options select.
std::size_t count_rows(std::vector<std::string> words) {
  words.emplace_back("--benchmark_list_tests=true");
  if (!initialize(words)) return 0;
  std::ostringstream ignored;
  benchmark::ConsoleReporter lister;
  lister.SetOutputStream(&ignored);
  const std::size_t rows = benchmark::RunSpecifiedBenchmarks(&lister);
  words.back() = "--benchmark_list_tests=false";
  return initialize(words) ? rows : 0;
}

}  // namespace

int run_benchmarks(std::vector<std::string> words) {
  if (has(words, "--benchmark_list_tests") || has(words, "--benchmark_list_tests=true")) {
    if (!initialize(words)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
  }
  const std::size_t rows = count_rows(words);
  if (rows == 0) return 2;
  run = std::make_unique<Run>();
  run->asked = rows;
  Reporter reporter(has(words, "--benchmark_format=json"));
  std::optional<Interrupted> interrupted;
  try {
    benchmark::RunSpecifiedBenchmarks(&reporter);
  } catch (const SignalReceived&) {
    interrupted = run->interruption.after(run->rows, run->asked, "benchmarks");
  }
  run->progress.clear();
  reporter.end(interrupted);
  run.reset();
  if (interrupted) return static_cast<int>(interrupted->exit_code());
  benchmark::Shutdown();
  return 0;
}

void show_progress(double done, double all, const std::string& unit) {
  if (!run) return;
  if (run->interruption.requested()) throw SignalReceived{};
  const std::string row = "benchmark " + std::to_string(run->rows + 1) + " of " + std::to_string(run->asked);
  run->progress.show(row, done, all, unit);
}

void set_iteration_time(benchmark::State& state, double microseconds) {
  state.SetIterationTime(microseconds * 1e-6);
  if (!run) return;
  const auto all = static_cast<double>(state.max_iterations);
  run->iterations = run->iterations >= all ? 1 : run->iterations + 1;
  if (all > 1) show_progress(run->iterations, all, "iterations");
}

}  // namespace hecaton::bench
