#pragma once
/// The nearest of a growing set of points.

#include <algorithm>
#include <cmath>
#include <vector>

#include "planner/global/validity_data.hpp"

namespace hecaton::planner::global {

struct Neighbour {
  int index = -1;
  float distance2 = 0.0F;  ///< squared

  /// Nearer, or as near and before it.
  bool operator<(const Neighbour& other) const {
    return distance2 != other.distance2 ? distance2 < other.distance2 : index < other.index;
  }
};

/// The nearest of what it is offered, at most `count` > 0 of them.
class NearestFew {
 public:
  NearestFew(int count, std::vector<Neighbour>& out) : count_(static_cast<std::size_t>(count)), heap_(out) {
    heap_.clear();
  }

  /// Nothing beyond this is taken any more; what is just as far may be.
  [[nodiscard]] float limit() const { return heap_.size() < count_ ? HUGE_VALF : heap_.front().distance2; }
  void offer(const Neighbour& neighbour) {
    if (heap_.size() == count_) {
      if (!(neighbour < heap_.front())) return;
      std::pop_heap(heap_.begin(), heap_.end());
      heap_.back() = neighbour;
    } else {
      heap_.push_back(neighbour);
    }
    std::push_heap(heap_.begin(), heap_.end());
  }
  /// Nearest first.
  void sort() { std::sort_heap(heap_.begin(), heap_.end()); }

 private:
  std::size_t count_;
  std::vector<Neighbour>& heap_;
};

/// Points that are compared eight at a time.
class PointGroups {
 public:
  explicit PointGroups(int dimensions) : dimensions_(dimensions) {}

  void add(const float* q);
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] float coordinate(int i, int j) const {
    return groups_[static_cast<std::size_t>(i / kWidth * dimensions_ + j) * kWidth + i % kWidth];
  }
  /// The first of the nearest; none (−1) of no points.
  [[nodiscard]] Neighbour nearest(const float* q) const;
  /// The `count` > 0 nearest, or all where there are fewer: nearest first, of those just as near the first.
  void nearest(const float* q, int count, std::vector<Neighbour>& out) const;
  /// All points nearer than `radius`, in the order of their indices.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;
  /// Of every point, and of some that are none behind them.
  void distances2(const float* q, std::vector<float>& out) const;

 private:
  int dimensions_;
  int size_ = 0;
  std::vector<float> groups_;  ///< coordinate by coordinate; filled up with far ones
};

/// The kernel's two compilations.
struct NearestKernel {
  Neighbour (*nearest)(const float* groups, int count, int dimensions, const float* q);
  void (*distances2)(const float* groups, int count, int dimensions, const float* q, float* out);
};
namespace baseline {
extern const NearestKernel kNearest;
}
namespace avx2 {
extern const NearestKernel kNearest;
}

}  // namespace hecaton::planner::global
