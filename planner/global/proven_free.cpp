/// Continuous collision checking by bounds on motion, as [Schwarzer05] has it, in lanes: a body that is clear by more
/// than it can move until the next configuration is free on the way there.

#include <algorithm>
#include <cmath>

#include "planner/global/validity.hpp"
#include "planner/global/validity_kernel.hpp"

namespace hecaton::planner::global {
namespace {

/// Stretches on which nothing moves farther than this are no longer halved: they count as blocked [m].
constexpr float kFinest = 2e-5F;
/// Exact distances are asked for where they may save halving: below some of what covering balls stick out [m].
constexpr float kCoarse = 8e-3F;
/// More stretches at a time than this are more than a way that only grazes something needs.
constexpr std::size_t kMostStretches = 1U << 14U;

/// q = (1 − t)² a + 2 t (1 − t) c + t² b.
struct Curve {
  const float* a;
  const float* c;
  const float* b;
  int stride;

  void at(float t, float* q) const {
    const float s = 1.0F - t;
    for (int j = 0; j < stride; ++j) q[j] = s * s * a[j] + 2.0F * s * t * c[j] + t * t * b[j];
  }
  /// |dq/dt| is never larger: it is linear in t, between 2 (c − a) and 2 (b − c).
  [[nodiscard]] float fastest(int j) const { return 2.0F * std::max(std::abs(c[j] - a[j]), std::abs(b[j] - c[j])); }
  /// No shorter than the way, in joint space; a line's length.
  [[nodiscard]] double longest() const {
    double sum = 0.0;
    for (int j = 0; j < stride; ++j) sum += std::pow(fastest(j), 2);
    return std::sqrt(sum);
  }
};

/// How far bodies move at most when each joint j moves by steps(j), and one of a pair as seen from the other: joints
/// that move both do not move them against each other.
struct Motion {
  std::vector<float> body;
  std::vector<float> pair;

  template <typename Steps>
  Motion(const KernelRobot& robot, const std::vector<float>& levers, const Steps& steps)
      : body(robot.bodies.size(), 0.0F), pair(robot.pairs.size(), 0.0F) {
    for (int j = 0; j < robot.dimensions; ++j) {
      const float step = steps(j);
      const auto lever = [&](int i) { return levers[i * robot.dimensions + j]; };
      for (int i = 0; i < static_cast<int>(body.size()); ++i) body[i] += lever(i) * step;
      for (std::size_t i = 0; i < pair.size(); ++i) {
        const float one = lever(robot.pairs[i].a);
        const float two = lever(robot.pairs[i].b);
        if (one <= 0.0F || two <= 0.0F) pair[i] += (one + two) * step;
      }
    }
  }
};

/// Of `count` stretches, a multiple of eight, of `half` to either side. Eight at a time from all over the way: what is
/// in the way is met early.
std::vector<float> first_middles(int count, float half) {
  std::vector<float> middles(count);
  for (int i = 0; i < count; ++i) {
    const int place = i % kWidth * (count / kWidth) + i / kWidth;
    middles[i] = static_cast<float>(2 * place + 1) * half;
  }
  return middles;
}

/// values · factor + beyond
std::vector<float> times(const std::vector<float>& values, float factor, const std::vector<float>& beyond) {
  std::vector<float> result(values.size());
  std::transform(values.begin(), values.end(), beyond.begin(), result.begin(),
                 [factor](float x, float more) { return x * factor + more; });
  return result;
}

}  // namespace

bool Validity::proven_free(const float* a, const float* b, double clearance) const {
  std::vector<float> middle(stride());
  for (int j = 0; j < stride(); ++j) middle[j] = 0.5F * (a[j] + b[j]);
  return proven_free(a, middle.data(), b, clearance);
}

bool Validity::proven_free(const float* a, const float* corner, const float* b, double clearance,
                           const float* spread) const {
  const Curve curve{a, corner, b, stride()};
  const Motion speeds(robot_, levers_, [&](int j) { return curve.fastest(j); });  // for a unit of t
  const Motion beyond(robot_, levers_, [&](int j) { return spread == nullptr ? 0.0F : spread[j]; });
  const float fastest = *std::max_element(speeds.body.begin(), speeds.body.end());
  const int first = kWidth * std::max(1, static_cast<int>(std::ceil(curve.longest() / (options_.step * kWidth))));
  float half = 0.5F / static_cast<float>(first);
  std::vector<float> middles = first_middles(first, half);
  std::vector<float> halves;
  std::vector<float> q(static_cast<std::size_t>(kWidth) * stride());
  for (;; half *= 0.5F) {
    const std::vector<float> growth = times(speeds.body, half, beyond.body);
    const std::vector<float> pair_growth = times(speeds.pair, half, beyond.pair);
    const KernelSweep sweep{growth.data(), pair_growth.data(), static_cast<float>(options_.padding + clearance),
                            fastest * half < kCoarse};
    halves.clear();
    for (std::size_t i = 0; i < middles.size(); i += kWidth) {
      const std::size_t count = std::min<std::size_t>(kWidth, middles.size() - i);
      for (std::size_t lane = 0; lane < kWidth; ++lane) {
        curve.at(middles[i + std::min(lane, count - 1)], q.data() + lane * stride());
      }
      checks_ += kWidth;
      const SweepHits hits = fastest_validity().swept(robot_, world_, exact(), sweep, q.data(), stride());
      if (hits.sure != 0) return false;
      for (std::size_t lane = 0; lane < count; ++lane) {
        if ((hits.maybe >> lane & 1U) == 0) continue;
        halves.push_back(middles[i + lane] - 0.5F * half);
        halves.push_back(middles[i + lane] + 0.5F * half);
      }
    }
    if (halves.empty()) return true;
    if (fastest * half < kFinest || halves.size() > kMostStretches) return false;
    middles.swap(halves);
  }
}

}  // namespace hecaton::planner::global
