#pragma once
/// What the off-line stage concludes from simulated tasks [Mediavilla02, section 3.1].

#include <cstdint>
#include <span>
#include <vector>

namespace hecaton::planner {

/// The probability of a fault lies between these with so much confidence [Clopper34]: exact for a binomial experiment.
struct FaultBounds {
  double low = 0.0;
  double high = 1.0;
};
/// faults of tasks, 0 ≤ faults ≤ tasks; confidence below 1. No tasks: (0, 1).
[[nodiscard]] FaultBounds fault_bounds(std::int64_t faults, std::int64_t tasks, double confidence = 0.95);

struct Moments {
  double mean = 0.0;
  double deviation = 0.0;
};
[[nodiscard]] Moments moments(std::span<const std::int32_t> times);

/// Normalised cross-correlation of two series of the same length at lags 1 … lags: Σ (aₖ − ā)(bₖ₊ₗ − b̄) / (N σₐ σ_b).
/// Of a series without variation: zeros.
[[nodiscard]] std::vector<double> correlations(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                                               int lags);
/// The same at lag 0.
[[nodiscard]] double correlation(std::span<const std::int32_t> a, std::span<const std::int32_t> b);

}  // namespace hecaton::planner
