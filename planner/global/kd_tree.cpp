#include "planner/global/kd_tree.hpp"

#include <algorithm>

namespace hecaton::planner::global {
namespace {

/// A bucket of eight groups is compared in less time than a few turns in the tree take.
constexpr int kMostInBucket = 8 * kWidth;
/// Sums of squares are rounded: what is cut off must be farther by more than that.
constexpr float kRoundedDown = 1.0F - 1e-5F;

}  // namespace

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
  if (bucket.points.size() >= kMostInBucket) split(node);
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
    // Something lies below: were the median the least, the next value would have to do.
    cut = values[count / 2] > least ? values[count / 2] : *std::max_element(values.begin(), values.end());
  }
  if (axis < 0) {  // all the same point: the bucket grows
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

// The distance to a node's box is kept up coordinate by coordinate [Arya93].
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
  NearestFew few(count, out);
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

}  // namespace hecaton::planner::global
