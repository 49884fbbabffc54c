#pragma once
/// The configuration space of a search, and lists of its points.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "planner/global/validity_kernel.hpp"
#include "planner/local/random.hpp"

namespace hecaton::planner::global {

inline constexpr float kFullTurn = 6.2831853F;  ///< [rad]

/// A box in joint space. A point is a row of `stride` floats; those beyond `dimensions` are 0. The space is periodic in
/// continuous joints: points a full turn apart are equal, and distances take the short way round. Paths are unwrapped:
/// along a path, a continuous joint may leave the box.
struct Space {
  int dimensions = 0;              ///< joints of all planned arms
  int stride = 0;                  ///< floats from one point to the next
  std::vector<float> lower;        ///< [rad | m]
  std::vector<float> upper;        ///< [rad | m]
  std::vector<float> period = {};  ///< by joint: kFullTurn if it is continuous, else 0; empty: no joint is

  /// Draws a point of the box; every joint is uniform.
  void sample(Random& random, float* q) const {
    for (int j = 0; j < dimensions; ++j) q[j] = static_cast<float>(random.uniform(lower[j], upper[j]));
    for (int j = dimensions; j < stride; ++j) q[j] = 0.0F;
  }
  /// q = a + t (b − a)
  void interpolate(const float* a, const float* b, float t, float* q) const {
    for (int j = 0; j < stride; ++j) q[j] = a[j] + t * (b[j] - a[j]);
  }
  /// Euclidean distance, the short way round.
  [[nodiscard]] float distance(const float* a, const float* b) const {
    float sum = 0.0F;
    for (int j = 0; j < dimensions; ++j) {
      const float along = a[j] - b[j] - (periodic() ? full_turns(j, a[j] - b[j]) : 0.0F);
      sum += along * along;
    }
    return std::sqrt(sum);
  }

  [[nodiscard]] bool periodic() const { return !period.empty(); }  ///< some joint is continuous
  /// Full turns in a difference along joint j [rad]; 0 for about half a turn, so that removing them twice changes
  /// nothing.
  [[nodiscard]] float full_turns(int j, float difference) const {
    if (period[j] <= 0.0F || std::abs(difference) <= 0.500001F * period[j]) return 0.0F;
    return period[j] * std::round(difference / period[j]);
  }
  /// The periodic image of `to` that is nearest to `from`: `to` itself in a space that is not periodic, otherwise
  /// written to `image`.
  [[nodiscard]] const float* nearest_image(const float* from, const float* to, std::vector<float>& image) const {
    if (!periodic()) return to;
    image.assign(to, to + stride);
    for (int j = 0; j < dimensions; ++j) image[j] -= full_turns(j, to[j] - from[j]);
    return image.data();
  }
};

/// A list of points.
class Points {
 public:
  explicit Points(int stride = kWidth) : stride_(stride) {}  ///< an empty list; `stride` as of its Space

  [[nodiscard]] int size() const { return static_cast<int>(values_.size()) / stride_; }  ///< number of points
  [[nodiscard]] int stride() const { return stride_; }  ///< floats from one point to the next
  /// Point i, valid until the list grows.
  [[nodiscard]] const float* operator[](int i) const {
    return values_.data() + static_cast<std::ptrdiff_t>(i) * stride_;
  }
  /// Point i, valid until the list grows.
  [[nodiscard]] float* operator[](int i) { return values_.data() + static_cast<std::ptrdiff_t>(i) * stride_; }
  /// Appends a point, which may be one of this list.
  void add(const float* q) {
    // q may be one of these points; resize() would move it.
    const std::ptrdiff_t own = q - values_.data();
    const bool inside = own >= 0 && own < static_cast<std::ptrdiff_t>(values_.size());
    values_.resize(values_.size() + stride_);
    const float* from = inside ? values_.data() + own : q;
    std::copy(from, from + stride_, values_.end() - stride_);
  }
  void reverse();  ///< the last point becomes the first
  /// Makes a path without jumps: replaces each point by its image nearest to the one before, the first by its image
  /// nearest to `start`.
  void unwrap(const Space& space, const float* start);
  void clear() { values_.clear(); }  ///< removes all points

 private:
  int stride_;
  std::vector<float> values_;
};

inline void Points::reverse() {
  for (int i = 0, k = size() - 1; i < k; ++i, --k) std::swap_ranges((*this)[i], (*this)[i] + stride_, (*this)[k]);
}

inline void Points::unwrap(const Space& space, const float* start) {
  if (!space.periodic()) return;
  std::vector<float> image;
  const float* before = start;
  for (int i = 0; i < size(); ++i) {
    const float* q = space.nearest_image(before, (*this)[i], image);
    std::copy(q, q + stride_, (*this)[i]);
    before = (*this)[i];
  }
}

}  // namespace hecaton::planner::global
