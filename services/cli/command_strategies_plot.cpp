#include <cstdio>
#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/cli/strategy_plot.hpp"
#include "services/cli/strategy_table.hpp"

namespace hecaton::services::cli {
namespace {

struct Options {
  std::string file;
  std::string picture;
};

/// A path in gnuplot's single quotes.
std::string quoted(const std::string& path) {
  std::string text = "'";
  for (const char c : path) text += c == '\'' ? std::string("''") : std::string(1, c);
  return text + "'";
}

/// T(L) against the share of faults, one point a strategy, and its standard error.
std::string script(const StrategyResults& results, const Options& options) {
  std::string text = "set terminal svg size 800,560 dynamic background rgb 'white'\nset output " +
                     quoted(options.picture) +
                     "\nset xlabel 'faults of tasks [%]'\nset ylabel 'T(L) [steps]'\nset logscale y\nset grid\n"
                     "set key top left\nset offsets graph 0.02, graph 0.02, graph 0.05, graph 0.05\n$found << EOD\n";
  for (const StrategyRow& row : results.rows) {
    text += decimal_text(100.0 * static_cast<double>(row.faults) / static_cast<double>(row.tasks), 6) + " " +
            decimal_text(row.time, 6) + " " + decimal_text(row.error, 6) + "\n";
  }
  return text + "EOD\nplot $found using 1:2:3 with yerrorbars pt 7 ps 0.4 lc rgb '#3465a4' title '" +
         std::to_string(results.rows.size()) + " strategies'\n";
}

ExitCode run(const Options& options) {
  const StrategyResults results = read_strategy_csv(options.file);
  const std::string text = script(results, options);
  std::FILE* gnuplot = popen("gnuplot 2>/dev/null", "w");
  const bool written = gnuplot != nullptr && std::fputs(text.c_str(), gnuplot) >= 0;
  const int status = gnuplot != nullptr ? pclose(gnuplot) : -1;
  constexpr int kNoProgram = 127 << 8;  // as the shell says it
  if (status == kNoProgram) {
    throw Failure(ExitCode::kBadInput, "pictures are drawn by gnuplot, which is not installed (Debian: gnuplot-nox)");
  }
  std::error_code none;
  if (!written || status != 0 || std::filesystem::file_size(options.picture, none) == 0 || none) {
    throw Failure(ExitCode::kBadInput, "file '" + options.picture + "' cannot be written");
  }
  std::fprintf(stderr, "%zu strategies in %s\n", results.rows.size(), options.picture.c_str());
  return ExitCode::kDone;
}

}  // namespace

void add_strategy_plot(CLI::App& parent, Session& session) {
  CLI::App* command =
      parent.add_subcommand("plot", "Draws the time of strategies against their faults, as SVG (by gnuplot)");
  auto options = std::make_shared<Options>();
  command->add_option("FILE", options->file, "results (CSV) of a search; with --complete it has strategies with faults")
      ->required();
  command->add_option("--picture", options->picture, "the file to write (strategies.svg)")->type_name("FILE");
  options->picture = "strategies.svg";
  command->callback([&session, options] { session.action = [options] { return run(*options); }; });
}

}  // namespace hecaton::services::cli
