#include "world/model/point_cloud.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace hecaton::world {
namespace {

/// Sides of boxes that nothing meets [m]. Squared gaps to them are still floats.
constexpr float kNowhere = 1e18F;
/// Squared gaps are this share smaller, which is more than rounding costs.
constexpr float kRoundedDown = 1.0F - 1e-6F;

/// A strict order of different points, so that a tree does not depend on the order in which they came.
struct Before {
  int axis;
  bool operator()(const Eigen::Vector3f& a, const Eigen::Vector3f& b) const {
    for (int k = 0; k < 3; ++k) {
      const int i = (axis + k) % 3;
      if (a[i] != b[i]) return a[i] < b[i];
    }
    return false;
  }
};

int widest(const PointBox& box) {
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (box.high[k] - box.low[k] > box.high[axis] - box.low[axis]) axis = k;
  }
  return axis;
}

/// How many of n > kPointFan points the lower half gets: whole leaves.
int lower_half(int n) {
  const int leaves = (n + kPointFan - 1) / kPointFan;
  return (leaves + 1) / 2 * kPointFan;
}

}  // namespace

PointCloud::PointCloud(std::vector<Eigen::Vector3f> points, double radius)
    : radius_(radius), points_(std::move(points)) {
  if (!std::isfinite(radius) || radius <= 0.0) {
    throw std::invalid_argument("radius = " + std::to_string(radius) + " m must be finite and > 0");
  }
  if (points_.empty() || points_.size() > kMostPoints) {
    throw std::invalid_argument("a cloud must have 1 to " + std::to_string(kMostPoints) + " points, not " +
                                std::to_string(points_.size()));
  }
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (!points_[i].allFinite()) {
      throw std::invalid_argument("point " + std::to_string(i + 1) + " of " + std::to_string(points_.size()) +
                                  " must have finite coordinates");
    }
  }
  for (Eigen::Vector3f& point : points_) point += Eigen::Vector3f::Zero();  // −0 becomes 0: equal points are the same
  std::sort(points_.begin(), points_.end(), Before{0});
  points_.erase(std::unique(points_.begin(), points_.end()), points_.end());

  const int count = static_cast<int>(points_.size());
  box_ = box_of(0, count);
  leaves_.reserve(static_cast<std::size_t>((count + kPointFan - 1) / kPointFan));
  if (const int root = build(0, count); root < 0) {
    nodes_.emplace_back();
    nodes_.back().count = 0;
    put_child(0, 0, root, box_);
  }
  for (PointNode& node : nodes_) {
    for (int k = node.count; k < kPointFan; ++k) {
      for (int axis = 0; axis < 3; ++axis) node.low[axis][k] = node.high[axis][k] = kNowhere;
      node.child[k] = node.child[0];
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    centre_[axis] = 0.5 * (static_cast<double>(box_.low[axis]) + static_cast<double>(box_.high[axis]));
  }
  for (const Eigen::Vector3f& point : points_) {
    bounding_radius_ = std::max(bounding_radius_, (point.cast<double>() - centre_).norm());
  }
  bounding_radius_ += radius_;
}

PointBox PointCloud::box_of(int first, int end) const {
  PointBox box{};
  for (int axis = 0; axis < 3; ++axis) {
    box.low[axis] = box.high[axis] = points_[static_cast<std::size_t>(first)][axis];
    for (int i = first + 1; i < end; ++i) {
      const float value = points_[static_cast<std::size_t>(i)][axis];
      box.low[axis] = std::min(box.low[axis], value);
      box.high[axis] = std::max(box.high[axis], value);
    }
  }
  return box;
}

int PointCloud::make_leaf(int first, int end) {
  PointLeaf& leaf = leaves_.emplace_back();
  leaf.count = end - first;
  for (int k = 0; k < kPointFan; ++k) {
    for (int axis = 0; axis < 3; ++axis) {
      leaf.p[axis][k] = points_[static_cast<std::size_t>(k < leaf.count ? first + k : first)][axis];
    }
  }
  return ~(static_cast<int>(leaves_.size()) - 1);
}

void PointCloud::put_child(int node, int place, int child, const PointBox& box) {
  PointNode& to = nodes_[static_cast<std::size_t>(node)];
  for (int axis = 0; axis < 3; ++axis) {
    to.low[axis][place] = box.low[axis];
    to.high[axis][place] = box.high[axis];
  }
  to.child[place] = child;
  to.count = std::max(to.count, place + 1);
}

int PointCloud::build(int first, int end) {
  if (end - first <= kPointFan) return make_leaf(first, end);
  // Cuts the largest part in half, until there are sixteen or all are leaves.
  struct Part {
    int first;
    int end;
    PointBox box;
  };
  std::vector<Part> parts{{first, end, box_of(first, end)}};
  while (parts.size() < kPointFan) {
    const auto largest = std::max_element(
        parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.end - a.first < b.end - b.first; });
    if (largest->end - largest->first <= kPointFan) break;
    const int middle = largest->first + lower_half(largest->end - largest->first);
    const auto begin = points_.begin();
    std::nth_element(begin + largest->first, begin + middle, begin + largest->end, Before{widest(largest->box)});
    const Part upper{middle, largest->end, box_of(middle, largest->end)};
    *largest = {largest->first, middle, box_of(largest->first, middle)};
    parts.push_back(upper);
  }
  const int node = static_cast<int>(nodes_.size());
  nodes_.emplace_back();
  nodes_.back().count = 0;
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.first < b.first; });
  for (int i = 0; i < static_cast<int>(parts.size()); ++i) {
    const Part& part = parts[static_cast<std::size_t>(i)];
    if (part.end - part.first <= kPointFan)
      std::sort(points_.begin() + part.first, points_.begin() + part.end, Before{0});
    const int child = build(part.first, part.end);
    put_child(node, i, child, part.box);
  }
  return node;
}

void squared_gaps(const PointNode& node, const PointBox& box, float (&out)[kPointFan]) {
  float sum[kPointFan] = {};
  for (int axis = 0; axis < 3; ++axis) {
    const float low = box.low[axis];
    const float high = box.high[axis];
    const float* const node_low = node.low[axis];
    const float* const node_high = node.high[axis];
    for (int k = 0; k < kPointFan; ++k) {
      const float below = node_low[k] - high;
      const float above = low - node_high[k];
      float gap = below > above ? below : above;
      gap = gap > 0.0F ? gap : 0.0F;
      sum[k] += gap * gap;
    }
  }
  for (int k = 0; k < kPointFan; ++k) out[k] = sum[k] * kRoundedDown;
}

}  // namespace hecaton::world
