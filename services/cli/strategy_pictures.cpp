#include "services/cli/strategy_pictures.hpp"

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include "services/cli/failure.hpp"
#include "services/cli/quantities.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kTitle = "group,variant,candidates,screened,confirmed,time";
constexpr std::size_t kTexts = 2;
constexpr std::size_t kNumbers = 4;

/// A field with commas in it is quoted.
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

/// As a string of gnuplot's data.
std::string label(const std::string& text) {
  std::string safe = "\"";
  for (const char c : text) safe += c == '"' || c == '\\' || static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  return safe + "\"";
}

}  // namespace

bool is_sensitivity(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  return std::getline(file, line) && line == kTitle;
}

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
    if (fields.size() != kTexts + kNumbers) fail("it must have as many values as the first line");
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
  if (rows.empty()) throw Failure(ExitCode::kBadInput, path + " must have a variant at least");
  return rows;
}

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

}  // namespace hecaton::services::cli
