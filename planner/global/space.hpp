#pragma once
/// The configuration space that is searched, and lists of its points.

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "planner/global/validity_data.hpp"
#include "planner/local/random.hpp"

namespace hecaton::planner::global {

inline constexpr float kTurn = 6.2831853F;  ///< [rad]

/// A box in joint space. Points are `stride` floats, those beyond `dimensions` zero. Along a joint that turns without
/// end it is closed: points a whole turn apart are the same, and distances go the short way round. Ways are not closed:
/// along them joints go on beyond the box.
struct Space {
  int dimensions = 0;
  int stride = 0;
  std::vector<float> lower;  ///< [rad | m]
  std::vector<float> upper;
  std::vector<float> turns = {};  ///< by joint: kTurn of one that turns without end, 0 of others; empty: none does

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
    for (int j = 0; j < dimensions; ++j) {
      const float along = a[j] - b[j] - (closed() ? whole_turns(j, a[j] - b[j]) : 0.0F);
      sum += along * along;
    }
    return std::sqrt(sum);
  }

  [[nodiscard]] bool closed() const { return !turns.empty(); }
  /// What of a difference along joint j is turns, none where it is about half a turn: doing so twice changes nothing.
  [[nodiscard]] float whole_turns(int j, float difference) const {
    if (turns[j] <= 0.0F || std::abs(difference) <= 0.500001F * turns[j]) return 0.0F;
    return turns[j] * std::round(difference / turns[j]);
  }
  /// `to` as it is reached from `from` the short way round: `to` itself in an open space, otherwise in `place`.
  [[nodiscard]] const float* beside(const float* from, const float* to, std::vector<float>& place) const {
    if (!closed()) return to;
    place.assign(to, to + stride);
    for (int j = 0; j < dimensions; ++j) place[j] -= whole_turns(j, to[j] - from[j]);
    return place.data();
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
  /// Each of them beside the one before (Space::beside), the first beside `start`: a way without jumps.
  void join_turns(const Space& space, const float* start);
  void clear() { values_.clear(); }

 private:
  int stride_;
  std::vector<float> values_;
};

inline void Points::reverse() {
  for (int i = 0, k = size() - 1; i < k; ++i, --k) std::swap_ranges((*this)[i], (*this)[i] + stride_, (*this)[k]);
}

inline void Points::join_turns(const Space& space, const float* start) {
  if (!space.closed()) return;
  std::vector<float> place;
  const float* before = start;
  for (int i = 0; i < size(); ++i) {
    const float* q = space.beside(before, (*this)[i], place);
    std::copy(q, q + stride_, (*this)[i]);
    before = (*this)[i];
  }
}

}  // namespace hecaton::planner::global
