#include "planner/global/nearest_points.hpp"

#include <limits>
#include <utility>

#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner::global {
namespace {

/// Coordinate of padding points; its square is still finite.
constexpr float kFar = 1e18F;

const NearestKernel& kernel() {
  static const NearestKernel& chosen = *fastest(&baseline::kNearest, &avx2::kNearest);
  return chosen;
}

/// A scan of eight groups costs less than a few levels of the tree.
constexpr int kMaxInBucket = 8 * kWidth;
/// A pruned box must be farther by more than the rounding of sums of squares.
constexpr float kRoundedDown = 1.0F - 1e-5F;

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
  KNearest few(count, out);
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

KdTree::KdTree(int dimensions) : dimensions_(dimensions), nodes_{{-1, 0.0F, 0, -1}} {
  buckets_.push_back({PointGroups(dimensions), {}});
}

void KdTree::add(const float* q) {
  int node = 0;
  while (nodes_[node].axis >= 0)
    node = q[nodes_[node].axis] < nodes_[node].cut ? nodes_[node].below : nodes_[node].above;
  Bucket& bucket = buckets_[nodes_[node].below];
  bucket.points.add(q);
  bucket.indices.push_back(size_++);
  if (bucket.points.size() >= kMaxInBucket) split(node);
}

void KdTree::split(int node) {
  const int place = nodes_[node].below;
  const Bucket full = std::move(buckets_[place]);
  const int count = full.points.size();
  std::vector<float> values(count);
  float widest = 0.0F;
  int axis = -1;
  float cut = 0.0F;
  for (int j = 0; j < dimensions_; ++j) {
    for (int i = 0; i < count; ++i) values[i] = full.points.coordinate(i, j);
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    if (*high - *low <= widest) continue;
    widest = *high - *low;
    axis = j;
    const float least = *low;
    std::nth_element(values.begin(), values.begin() + count / 2, values.end());
    // Both sides get points: if the median is the minimum, the cut is the maximum.
    cut = values[count / 2] > least ? values[count / 2] : *std::max_element(values.begin(), values.end());
  }
  if (axis < 0) {  // all points are equal: the bucket grows
    buckets_[place] = full;
    return;
  }
  buckets_[place] = {PointGroups(dimensions_), {}};
  buckets_.push_back({PointGroups(dimensions_), {}});
  const int above = static_cast<int>(buckets_.size()) - 1;
  std::vector<float> q(dimensions_);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < dimensions_; ++j) q[j] = full.points.coordinate(i, j);
    Bucket& bucket = buckets_[q[axis] < cut ? place : above];
    bucket.points.add(q.data());
    bucket.indices.push_back(full.indices[i]);
  }
  const int first = static_cast<int>(nodes_.size());
  nodes_.push_back({-1, 0.0F, place, -1});
  nodes_.push_back({-1, 0.0F, above, -1});
  nodes_[node] = {axis, cut, first, first + 1};
}

// Updates the distance to a node's box incrementally, coordinate by coordinate [Arya93].
template <typename Limit, typename Look>
void KdTree::visit(int index, const float* q, float bound, Offsets& offsets, const Limit& limit,
                   const Look& look) const {
  const Node& node = nodes_[index];
  if (node.axis < 0) {
    look(buckets_[node.below]);
    return;
  }
  const float away = q[node.axis] - node.cut;
  const bool below = away < 0.0F;
  visit(below ? node.below : node.above, q, bound, offsets, limit, look);
  float& offset = offsets.of[node.axis];
  const float before = offset;
  const float farther = bound - before * before + away * away;
  if (farther * kRoundedDown > limit()) return;
  offset = away;
  visit(below ? node.above : node.below, q, farther, offsets, limit, look);
  offset = before;
}

Neighbour KdTree::nearest(const float* q) const {
  Neighbour best{-1, 3e38F};
  Offsets offsets;
  visit(
      0, q, 0.0F, offsets, [&] { return best.distance2; },
      [&](const Bucket& bucket) {
        Neighbour near = bucket.points.nearest(q);
        if (near.index < 0) return;
        near.index = bucket.indices[near.index];
        if (near < best) best = near;
      });
  return best;
}

void KdTree::nearest(const float* q, int count, std::vector<Neighbour>& out) const {
  KNearest few(count, out);
  std::vector<float> distances;
  Offsets offsets;
  visit(
      0, q, 0.0F, offsets, [&] { return few.limit(); },
      [&](const Bucket& bucket) {
        bucket.points.distances2(q, distances);
        for (int i = 0; i < bucket.points.size(); ++i) {
          if (distances[i] <= few.limit()) few.offer({bucket.indices[i], distances[i]});
        }
      });
  few.sort();
}

void KdTree::within(const float* q, float radius, std::vector<Neighbour>& out) const {
  out.clear();
  std::vector<float> distances;
  Offsets offsets;
  visit(
      0, q, 0.0F, offsets, [&] { return radius * radius; },
      [&](const Bucket& bucket) {
        bucket.points.distances2(q, distances);
        for (int i = 0; i < bucket.points.size(); ++i) {
          if (distances[i] < radius * radius) out.push_back({bucket.indices[i], distances[i]});
        }
      });
  std::sort(out.begin(), out.end(), [](const Neighbour& a, const Neighbour& b) { return a.index < b.index; });
}

int NearestPoints::tree_threshold(int dimensions) {
  if (dimensions <= 3) return 512;
  if (dimensions <= 7) return 4096;
  if (dimensions <= 9) return 8192;
  if (dimensions <= 12) return 32768;
  return std::numeric_limits<int>::max();
}

void NearestPoints::add(const float* q) {
  if (period_.empty()) {
    add_wrapped(q);
  } else {
    add_wrapped(wrapped(q).data());
  }
}

std::vector<float> NearestPoints::wrapped(const float* q) const {
  std::vector<float> result(q, q + dimensions_);
  for (int j = 0; j < dimensions_; ++j) {
    if (period_[j] > 0.0F) result[j] = std::remainder(q[j], period_[j]);
  }
  return result;
}

Neighbour NearestPoints::nearest_of_images(const float* q) const {
  Neighbour best{-1, std::numeric_limits<float>::max()};
  std::vector<float> copy = wrapped(q);
  visit_images(0, 0.0F, copy, best);
  return best;
}

void NearestPoints::visit_images(int j, float bound, std::vector<float>& q, Neighbour& best) const {
  while (j < dimensions_ && period_[j] <= 0.0F) ++j;
  if (j == dimensions_) {
    const Neighbour near = find(q.data());
    if (near.index < 0 || near.distance2 > best.distance2) return;
    if (near.distance2 < best.distance2 || near.index < best.index || best.index < 0) best = near;
    return;
  }
  visit_images(j + 1, bound, q, best);
  // All points lie within half a period of zero; the other image of q is outside by as much as q is inside.
  constexpr float kImageRounding = 0.999F;
  const float away = std::max(0.0F, 0.5F * period_[j] - std::abs(q[j]));
  const float farther = bound + away * away;
  if (farther * kImageRounding > best.distance2) return;
  const float before = q[j];
  q[j] = before > 0.0F ? before - period_[j] : before + period_[j];
  visit_images(j + 1, farther, q, best);
  q[j] = before;
}

void NearestPoints::nearest(const float* q, int count, std::vector<Neighbour>& out) const {
  if (!period_.empty()) {
    within(q, std::numeric_limits<float>::max(), out);
    const auto few = std::min(static_cast<std::ptrdiff_t>(out.size()), static_cast<std::ptrdiff_t>(count));
    std::partial_sort(out.begin(), out.begin() + few, out.end());
    out.resize(static_cast<std::size_t>(few));
  } else if (tree_) {
    tree_->nearest(q, count, out);
  } else {
    all_.nearest(q, count, out);
  }
}

void NearestPoints::within(const float* q, float radius, std::vector<Neighbour>& out) const {
  if (period_.empty()) {
    tree_ ? tree_->within(q, radius, out) : all_.within(q, radius, out);
    return;
  }
  const std::vector<float> copy = wrapped(q);
  out.clear();
  for (int i = 0; i < size(); ++i) {
    float sum = 0.0F;
    for (int j = 0; j < dimensions_; ++j) {
      float along = std::abs(copy[j] - all_.coordinate(i, j));
      if (period_[j] > 0.0F) along = std::min(along, std::abs(period_[j] - along));
      sum += along * along;
    }
    if (sum < radius * radius) out.push_back({i, sum});
  }
}

void NearestPoints::add_wrapped(const float* q) {
  all_.add(q);
  if (tree_) {
    tree_->add(q);
  } else if (all_.size() >= tree_threshold(dimensions_)) {
    tree_.emplace(dimensions_);
    std::vector<float> point(dimensions_);
    for (int i = 0; i < all_.size(); ++i) {
      for (int j = 0; j < dimensions_; ++j) point[j] = all_.coordinate(i, j);
      tree_->add(point.data());
    }
  }
}

}  // namespace hecaton::planner::global
