#pragma once
/// The configuration space that is searched, and lists of its points.

#include <cmath>
#include <span>
#include <vector>

#include "planner/global/validity_data.hpp"
#include "planner/local/random.hpp"

namespace hecaton::planner::global {

/// A box in joint space. Points are `stride` floats, those beyond `dimensions` zero.
struct Space {
  int dimensions = 0;
  int stride = 0;
  std::vector<float> lower;  ///< [rad | m]
  std::vector<float> upper;

  void sample(Random& random, float* q) const {
    for (int j = 0; j < dimensions; ++j) q[j] = static_cast<float>(random.uniform(lower[j], upper[j]));
    for (int j = dimensions; j < stride; ++j) q[j] = 0.0F;
  }
  /// q = a + t (b − a)
  void interpolate(const float* a, const float* b, float t, float* q) const {
    for (int j = 0; j < stride; ++j) q[j] = a[j] + t * (b[j] - a[j]);
  }
  [[nodiscard]] float distance(const float* a, const float* b) const {
    float sum = 0.0F;
    for (int j = 0; j < dimensions; ++j) sum += (a[j] - b[j]) * (a[j] - b[j]);
    return std::sqrt(sum);
  }
};

/// Points one after the other.
class Points {
 public:
  explicit Points(int stride = kWidth) : stride_(stride) {}

  [[nodiscard]] int size() const { return static_cast<int>(values_.size()) / stride_; }
  [[nodiscard]] int stride() const { return stride_; }
  [[nodiscard]] const float* operator[](int i) const {
    return values_.data() + static_cast<std::ptrdiff_t>(i) * stride_;
  }
  [[nodiscard]] float* operator[](int i) { return values_.data() + static_cast<std::ptrdiff_t>(i) * stride_; }
  void add(const float* q) {
    // q may be one of these points, which growing moves.
    const std::ptrdiff_t own = q - values_.data();
    const bool inside = own >= 0 && own < static_cast<std::ptrdiff_t>(values_.size());
    values_.resize(values_.size() + stride_);
    const float* from = inside ? values_.data() + own : q;
    std::copy(from, from + stride_, values_.end() - stride_);
  }
  void reverse();
  void clear() { values_.clear(); }

 private:
  int stride_;
  std::vector<float> values_;
};

inline void Points::reverse() {
  for (int i = 0, k = size() - 1; i < k; ++i, --k) std::swap_ranges((*this)[i], (*this)[i] + stride_, (*this)[k]);
}

}  // namespace hecaton::planner::global
