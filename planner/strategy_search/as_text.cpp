#include "planner/strategy_search/as_text.hpp"

#include <sstream>

namespace hecaton::planner {
namespace {

constexpr int kExactDigits = 17;
/// Ends each text: one that was cut off has none.
constexpr const char* kEnd = ".";

std::ostringstream exact_stream() {
  std::ostringstream out;
  out.precision(kExactDigits);
  return out;
}

bool ends(std::istringstream& words) {
  std::string end;
  return words >> end && end == kEnd && !(words >> end);
}

}  // namespace

std::string text_of(const Evaluation& evaluation) {
  std::ostringstream out = exact_stream();
  out << evaluation.complete << ' ' << evaluation.arm_ticks << ' ' << evaluation.tasks.size();
  for (std::size_t i = 0; i < evaluation.tasks.size(); ++i) {
    out << ' ' << evaluation.tasks[i] << ' ' << evaluation.faults[i] << ' ' << evaluation.time[i] << ' '
        << evaluation.time2[i];
  }
  out << ' ' << kEnd;
  return out.str();
}

std::optional<Evaluation> evaluation_of(const std::string& text) {
  std::istringstream words(text);
  Evaluation evaluation;
  std::size_t arms = 0;
  words >> evaluation.complete >> evaluation.arm_ticks >> arms;
  for (std::size_t i = 0; i < arms && words; ++i) {
    std::int64_t tasks = 0;
    std::int64_t faults = 0;
    double time = 0.0;
    double time2 = 0.0;
    words >> tasks >> faults >> time >> time2;
    evaluation.tasks.push_back(tasks);
    evaluation.faults.push_back(faults);
    evaluation.time.push_back(time);
    evaluation.time2.push_back(time2);
  }
  if (!ends(words)) return std::nullopt;
  return evaluation;
}

std::string text_of(const SystemStrategy& strategy) {
  std::ostringstream out = exact_stream();
  out << strategy.size();
  for (const Strategy& arm : strategy) {
    out << ' ' << arm.direction;
    for (const double coefficient : arm.coefficients) out << ' ' << coefficient;
  }
  out << ' ' << kEnd;
  return out.str();
}

std::optional<SystemStrategy> strategy_of(const std::string& text) {
  std::istringstream words(text);
  std::size_t arms = 0;
  SystemStrategy strategy;
  words >> arms;
  for (std::size_t i = 0; i < arms && words; ++i) {
    Strategy& arm = strategy.emplace_back();
    words >> arm.direction;
    for (double& coefficient : arm.coefficients) words >> coefficient;
  }
  if (!ends(words)) return std::nullopt;
  return strategy;
}

}  // namespace hecaton::planner
