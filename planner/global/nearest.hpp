#pragma once
/// The nearest of a growing set of points.

#include <vector>

#include "planner/global/validity_data.hpp"

namespace hecaton::planner::global {

struct Neighbour {
  int index = -1;
  float distance2 = 0.0F;  ///< squared
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
  /// All points nearer than `radius`, in the order of their indices.
  void within(const float* q, float radius, std::vector<Neighbour>& out) const;

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
