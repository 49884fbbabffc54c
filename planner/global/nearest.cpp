#include "planner/global/nearest.hpp"

#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner::global {
namespace {

constexpr float kFar = 1e18F;  ///< its square is still a number, and no arm gets there

const NearestKernel& kernel() {
  static const NearestKernel& chosen = *fastest(&baseline::kNearest, &avx2::kNearest);
  return chosen;
}

}  // namespace

void PointGroups::add(const float* q) {
  const int lane = size_ % kWidth;
  if (lane == 0) groups_.resize(groups_.size() + static_cast<std::size_t>(dimensions_) * kWidth, kFar);
  float* group = groups_.data() + groups_.size() - static_cast<std::ptrdiff_t>(dimensions_) * kWidth;
  for (int j = 0; j < dimensions_; ++j) group[j * kWidth + lane] = q[j];
  ++size_;
}

Neighbour PointGroups::nearest(const float* q) const {
  return kernel().nearest(groups_.data(), (size_ + kWidth - 1) / kWidth, dimensions_, q);
}

void PointGroups::distances2(const float* q, std::vector<float>& out) const {
  const int groups = (size_ + kWidth - 1) / kWidth;
  out.resize(static_cast<std::size_t>(groups) * kWidth);
  kernel().distances2(groups_.data(), groups, dimensions_, q, out.data());
}

void PointGroups::nearest(const float* q, int count, std::vector<Neighbour>& out) const {
  std::vector<float> distances;
  distances2(q, distances);
  NearestFew few(count, out);
  for (int i = 0; i < size_; ++i) {
    if (distances[i] < few.limit()) few.offer({i, distances[i]});
  }
  few.sort();
}

void PointGroups::within(const float* q, float radius, std::vector<Neighbour>& out) const {
  std::vector<float> distances;
  distances2(q, distances);
  out.clear();
  for (int i = 0; i < size_; ++i) {
    if (distances[i] < radius * radius) out.push_back({i, distances[i]});
  }
}

}  // namespace hecaton::planner::global
