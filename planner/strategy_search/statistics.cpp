#include "planner/strategy_search/statistics.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/distributions/binomial.hpp>

namespace hecaton::planner {
namespace {

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
