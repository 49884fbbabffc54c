#include <cstdio>
#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/failure.hpp"
#include "services/cli/strategy_pictures.hpp"
#include "services/cli/strategy_plot.hpp"

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

constexpr const char* kSvg = "set terminal svg size 900,560 dynamic background rgb 'white'\n";
constexpr const char* kPng = "set terminal pngcairo size 1200,750 background rgb 'white'\n";

std::string output(const std::string& picture) {
  const std::string ending = std::filesystem::path(picture).extension();
  if (ending != ".svg" && ending != ".png") {
    throw Failure(ExitCode::kBadInput, "--picture = " + picture + " must end in .svg or .png");
  }
  return (ending == ".png" ? kPng : kSvg) + ("set output " + quoted(picture) + "\n");
}

ExitCode run(const Options& options) {
  std::string text = output(options.picture);
  std::string what;
  if (is_sensitivity(options.file)) {
    const std::vector<SensitivityRow> rows = read_sensitivity(options.file);
    text += sensitivity_script(rows);
    what = std::to_string(rows.size()) + " variants";
  } else {
    const StrategyResults results = read_strategy_csv(options.file);
    text += faults_script(results);
    what = std::to_string(results.rows.size()) + " strategies";
  }
  std::error_code none;
  std::filesystem::remove(options.picture, none);  // one that was there would pass for this one
  std::FILE* gnuplot = popen("gnuplot >/dev/null 2>&1", "w");
  const bool written = gnuplot != nullptr && std::fputs(text.c_str(), gnuplot) >= 0;
  const int status = gnuplot != nullptr ? pclose(gnuplot) : -1;
  constexpr int kNoProgram = 127 << 8;  // as the shell says it
  if (status == kNoProgram) {
    throw Failure(ExitCode::kBadInput, "pictures are drawn by gnuplot, which is not installed (Debian: gnuplot-nox)");
  }
  if (!written || status != 0 || std::filesystem::file_size(options.picture, none) == 0 || none) {
    throw Failure(ExitCode::kBadInput, "file '" + options.picture + "' cannot be written");
  }
  std::fprintf(stderr, "%s in %s\n", what.c_str(), options.picture.c_str());
  return ExitCode::kDone;
}

}  // namespace

void add_strategy_plot(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand(
      "plot", "Draws the time of strategies against their faults, or a sensitivity table (by gnuplot)");
  auto options = std::make_shared<Options>();
  command
      ->add_option(
          "FILE", options->file,
          "results (CSV) of a search; with --complete it has strategies with faults. Or a sensitivity table (CSV) "
          "of tests/bench/strategy_sensitivity.py")
      ->required();
  command->add_option("--picture", options->picture, "the file to write, SVG or PNG (strategies.svg)")
      ->type_name("FILE");
  options->picture = "strategies.svg";
  command->callback([&session, options] { session.action = [options] { return run(*options); }; });
}

}  // namespace hecaton::services::cli
