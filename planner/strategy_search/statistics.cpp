#include "planner/strategy_search/statistics.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::planner {
namespace {

/// P(X ≤ k) of a binomial distribution, summed in logarithms.
double at_most(std::int64_t k, std::int64_t n, double p) {
  if (p <= 0.0) return 1.0;
  if (p >= 1.0) return k >= n ? 1.0 : 0.0;
  const auto of = [](std::int64_t x) { return std::lgamma(static_cast<double>(x) + 1.0); };
  double sum = 0.0;
  for (std::int64_t i = 0; i <= k; ++i) {
    const double choose = of(n) - of(i) - of(n - i);
    sum += std::exp(choose + static_cast<double>(i) * std::log(p) + static_cast<double>(n - i) * std::log1p(-p));
  }
  return std::min(sum, 1.0);
}

/// The p in [0, 1] at which P(X ≤ k), which falls with p, is `probability`.
double solve(std::int64_t k, std::int64_t n, double probability) {
  double low = 0.0;
  double high = 1.0;
  for (int step = 0; step < 100; ++step) {
    const double middle = 0.5 * (low + high);
    (at_most(k, n, middle) > probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
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

FaultBounds fault_bounds(std::int64_t faults, std::int64_t tasks, double confidence) {
  if (tasks <= 0) return {};
  const double tail = 0.5 * (1.0 - confidence);
  FaultBounds bounds;
  // [Clopper34] p_low: P(X ≥ faults) = tail; p_high: P(X ≤ faults) = tail.
  if (faults > 0) bounds.low = solve(faults - 1, tasks, 1.0 - tail);
  if (faults < tasks) bounds.high = solve(faults, tasks, tail);
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
