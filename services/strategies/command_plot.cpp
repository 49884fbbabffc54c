/// hecaton-strategies plot: plots of search results, by gnuplot.

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include <CLI/CLI.hpp>

#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"
#include "services/strategies/commands.hpp"
#include "services/strategies/results.hpp"

namespace hecaton::services::cli {
namespace {

/// One row of the sensitivity table (tests/bench/strategy_sensitivity.py writes it).
struct SensitivityRow {
  std::string group;    ///< what was changed: layout, basis, …
  std::string variant;  ///< to what
  double candidates = 0.0;
  double screened = 0.0;   ///< without fault in the first set
  double confirmed = 0.0;  ///< without fault after all sets
  double time = 0.0;       ///< T of the best [steps]
};

constexpr const char* kTitle = "group,variant,candidates,screened,confirmed,time";
constexpr std::size_t kTexts = 2;
constexpr std::size_t kNumbers = 4;

/// Splits a CSV line; a field with commas is quoted.
std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

/// A string in gnuplot data.
std::string label(const std::string& text) {
  std::string safe = "\"";
  for (const char c : text) safe += c == '"' || c == '\\' || static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  return safe + "\"";
}

/// True if the first line is that of a sensitivity table.
bool is_sensitivity(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  return std::getline(file, line) && line == kTitle;
}

/// Throws Failure (bad input) that names file and line.
std::vector<SensitivityRow> read_sensitivity(const std::string& path) {
  std::ifstream file(path);
  std::vector<SensitivityRow> rows;
  std::string line;
  std::getline(file, line);
  for (int number = 2; std::getline(file, line); ++number) {
    const auto fail = [&](const std::string& says) {
      throw Failure(ExitCode::kBadInput, path + ": line " + std::to_string(number) + ": " + says);
    };
    const std::vector<std::string> fields = fields_of(line);
    if (fields.size() != kTexts + kNumbers) fail("must have as many values as the first line");
    std::array<double, kNumbers> values{};
    for (std::size_t i = 0; i < kNumbers; ++i) {
      const auto value = config::parse_number(fields[kTexts + i]);
      if (!value || !std::isfinite(*value) || *value < 0.0) {
        fail("'" + config::printable(fields[kTexts + i]) + "' must be a finite number, not below 0");
      }
      values[i] = *value;
    }
    rows.push_back({fields[0], fields[1], values[0], values[1], values[2], values[3]});
  }
  if (rows.empty()) throw Failure(ExitCode::kBadInput, path + " has no rows");
  return rows;
}

/// Gnuplot script: T(L) with its standard error over the share of faults, one point per strategy.
std::string faults_script(const StrategyResults& results) {
  std::string text =
      "set xlabel 'faults of tasks [%]'\nset ylabel 'T(L) [steps]'\nset logscale y\nset grid\n"
      "set key top left\nset offsets graph 0.02, graph 0.02, graph 0.05, graph 0.05\n$found << EOD\n";
  for (const StrategyRow& row : results.rows) {
    text += decimal_text(100.0 * static_cast<double>(row.faults) / static_cast<double>(row.tasks), 6) + " " +
            decimal_text(row.time, 6) + " " + decimal_text(row.error, 6) + "\n";
  }
  return text + "EOD\nplot $found using 1:2:3 with yerrorbars pt 7 ps 0.4 lc rgb '#3465a4' title '" +
         std::to_string(results.rows.size()) + " strategies'\n";
}

/// Gnuplot script: number of strategies without fault, and the best T, of each variant.
std::string sensitivity_script(const std::vector<SensitivityRow>& rows) {
  std::string text = "$variants << EOD\n";
  for (const SensitivityRow& row : rows) {
    text += label(row.group + ": " + row.variant) + " " + decimal_text(row.screened, 0) + " " +
            decimal_text(row.confirmed, 0) + " " + decimal_text(row.time, 2) + "\n";
  }
  return text +
         "EOD\nset ylabel 'strategies without fault'\nset y2label 'T of the best [steps]'\nset ytics nomirror\n"
         "set y2tics\nset yrange [0:*]\nset y2range [0:*]\nset grid ytics\nset key top left\n"
         "set style fill solid 0.8 noborder\nset style histogram clustered gap 1\n"
         "set xtics rotate by 45 right noenhanced\nset bmargin 13\nset lmargin 12\n"
         "plot $variants using 2:xtic(1) with histograms lc rgb '#b0c4de' title 'after the first set', \\\n"
         "  '' using 3 with histograms lc rgb '#3465a4' title 'after all sets', \\\n"
         "  '' using 0:4 axes x1y2 with points pt 7 ps 0.8 lc rgb '#cc0000' title 'T of the best (right)'\n";
}

struct Options {
  std::string file;
  std::string image;
};

/// A path in single quotes of gnuplot.
std::string quoted(const std::string& path) {
  std::string text = "'";
  for (const char c : path) text += c == '\'' ? std::string("''") : std::string(1, c);
  return text + "'";
}

constexpr const char* kSvg = "set terminal svg size 900,560 dynamic background rgb 'white'\n";
constexpr const char* kPng = "set terminal pngcairo size 1200,750 background rgb 'white'\n";

std::string output(const std::string& image) {
  const std::string ending = std::filesystem::path(image).extension();
  if (ending != ".svg" && ending != ".png") {
    throw Failure(ExitCode::kBadInput, "--image = " + image + " must end in .svg or .png");
  }
  return (ending == ".png" ? kPng : kSvg) + ("set output " + quoted(image) + "\n");
}

ExitCode run(const Options& options) {
  std::string text = output(options.image);
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
  std::filesystem::remove(options.image, none);  // an old file would hide a failure
  std::FILE* gnuplot = popen("gnuplot >/dev/null 2>&1", "w");
  const bool written = gnuplot != nullptr && std::fputs(text.c_str(), gnuplot) >= 0;
  const int status = gnuplot != nullptr ? pclose(gnuplot) : -1;
  constexpr int kNoProgram = 127 << 8;  // exit code of the shell
  if (status == kNoProgram) {
    throw Failure(ExitCode::kBadInput, "gnuplot is not installed (Debian package gnuplot-nox)");
  }
  if (!written || status != 0 || std::filesystem::file_size(options.image, none) == 0 || none) {
    throw Failure(ExitCode::kBadInput, "file '" + options.image + "' cannot be written");
  }
  std::fprintf(stderr, "%s in %s\n", what.c_str(), config::valid_utf8(options.image).c_str());
  return ExitCode::kDone;
}

}  // namespace

void add_plot(CLI::App& parent, Session& session) {
  CLI::App* command = parent.add_subcommand(
      "plot", "Plots the time of strategies over their faults, or a sensitivity table (with gnuplot)");
  auto options = std::make_shared<Options>();
  command
      ->add_option("FILE", options->file,
                   "results (CSV) of a search, which has strategies with faults after --complete; or a sensitivity "
                   "table (CSV) of "
                   "tests/bench/strategy_sensitivity.py")
      ->required();
  command->add_option("--image", options->image, "output file, SVG or PNG (strategies.svg)")->type_name("FILE");
  options->image = "strategies.svg";
  command->callback([&session, options] { session.action = [options] { return run(*options); }; });
}

}  // namespace hecaton::services::cli
