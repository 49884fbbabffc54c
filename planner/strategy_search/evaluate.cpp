#include "planner/strategy_search/evaluate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include <boost/math/distributions/binomial.hpp>

namespace hecaton::planner {
namespace {

constexpr int kExactDigits = 17;
/// Ends each text, so that a truncated one is detected.
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

double covariance(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::size_t lag) {
  const double mean_a = moments(a).mean;
  const double mean_b = moments(b).mean;
  double sum = 0.0;
  for (std::size_t k = 0; k + lag < a.size(); ++k) sum += (a[k] - mean_a) * (b[k + lag] - mean_b);
  return sum / static_cast<double>(a.size());
}

double normalised(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::size_t lag) {
  const double scale = moments(a).deviation * moments(b).deviation;
  return scale > 0.0 ? covariance(a, b, lag) / scale : 0.0;
}

}  // namespace

std::int64_t Evaluation::all_tasks() const {
  return std::accumulate(tasks.begin(), tasks.end(), std::int64_t{0});
}

std::int64_t Evaluation::all_faults() const {
  return std::accumulate(faults.begin(), faults.end(), std::int64_t{0});
}

double Evaluation::fault_rate() const {
  return all_tasks() > 0 ? static_cast<double>(all_faults()) / static_cast<double>(all_tasks()) : 0.0;
}

double Evaluation::mean_time() const {
  double sum = 0.0;
  for (std::size_t i = 0; i < tasks.size(); ++i) sum += tasks[i] > 0 ? time[i] / static_cast<double>(tasks[i]) : 0.0;
  return sum;
}

double Evaluation::mean_time_error() const {
  double variance = 0.0;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (tasks[i] == 0) continue;
    const auto n = static_cast<double>(tasks[i]);
    variance += (time2[i] / n - (time[i] / n) * (time[i] / n)) / n;
  }
  return std::sqrt(std::max(0.0, variance));
}

Evaluation& Evaluation::operator+=(const Evaluation& other) {
  if (tasks.empty()) return *this = other;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    tasks[i] += other.tasks[i];
    faults[i] += other.faults[i];
    time[i] += other.time[i];
    time2[i] += other.time2[i];
  }
  arm_ticks += other.arm_ticks;
  complete = complete && other.complete;
  return *this;
}

Evaluation evaluate(const StrategyProblem& problem, const TaskSet& tasks, const SystemStrategy& strategy,
                    const EvaluateOptions& options) {
  static const RunKernel run = fastest_run();
  FlatStrategy flat[kFlatArms];
  for (int i = 0; i < problem.arms(); ++i) {
    for (int k = 0; k < kStrategyNumbers; ++k) flat[i].coefficients[k] = strategy[i].coefficients[k];
    flat[i].direction = strategy[i].direction;
  }
  RunOptions run_options;
  run_options.stop_at_fault = options.stop_at_fault;
  run_options.detect_cycles = options.detect_cycles;
  if (options.times != nullptr) {
    options.times->assign(problem.arms(), std::vector<std::int32_t>(tasks.tasks, 0));
    for (int i = 0; i < problem.arms(); ++i) run_options.times[i] = (*options.times)[i].data();
  }
  if (options.ended) {
    run_options.ended = [](void* context, std::int64_t finished) {
      return static_cast<const EvaluateOptions*>(context)->ended(finished);
    };
    run_options.context = const_cast<EvaluateOptions*>(&options);
  }
  RunResult result;
  run(problem.flat(), tasks.flat, flat, run_options, result);

  Evaluation evaluation;
  evaluation.arm_ticks = result.arm_ticks;
  evaluation.complete = true;
  for (int i = 0; i < problem.arms(); ++i) {
    evaluation.tasks.push_back(result.tasks[i]);
    evaluation.faults.push_back(result.faults[i]);
    evaluation.time.push_back(result.time[i]);
    evaluation.time2.push_back(result.time2[i]);
    evaluation.complete = evaluation.complete && result.tasks[i] == tasks.tasks;
    if (options.times != nullptr) (*options.times)[i].resize(result.tasks[i]);
  }
  return evaluation;
}

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

FaultBounds fault_bounds(std::int64_t faults, std::int64_t tasks, double confidence) {
  if (tasks <= 0) return {};
  using Binomial = boost::math::binomial_distribution<double>;
  const double tail = 0.5 * (1.0 - confidence);
  const auto n = static_cast<double>(tasks);
  const auto k = static_cast<double>(faults);
  FaultBounds bounds;
  // [Clopper34] p_low: P(X ≥ faults) = tail; p_high: P(X ≤ faults) = tail.
  if (faults > 0) bounds.low = Binomial::find_lower_bound_on_p(n, k, tail);
  if (faults < tasks) bounds.high = Binomial::find_upper_bound_on_p(n, k, tail);
  return bounds;
}

Moments moments(std::span<const std::int32_t> times) {
  if (times.empty()) return {};
  double sum = 0.0;
  for (const std::int32_t t : times) sum += t;
  const double mean = sum / static_cast<double>(times.size());
  double squares = 0.0;
  for (const std::int32_t t : times) squares += (t - mean) * (t - mean);
  return {mean, std::sqrt(squares / static_cast<double>(times.size()))};
}

std::vector<double> correlations(std::span<const std::int32_t> a, std::span<const std::int32_t> b, int lags) {
  std::vector<double> result;
  for (int lag = 1; lag <= lags; ++lag) result.push_back(normalised(a, b, static_cast<std::size_t>(lag)));
  return result;
}

double correlation(std::span<const std::int32_t> a, std::span<const std::int32_t> b) {
  return normalised(a, b, 0);
}

}  // namespace hecaton::planner
