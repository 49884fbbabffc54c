#include "planner/global/nearest_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hecaton::planner::global {

int NearestPoints::worth_a_tree(int dimensions) {
  if (dimensions <= 3) return 512;
  if (dimensions <= 7) return 4096;
  if (dimensions <= 9) return 8192;
  if (dimensions <= 12) return 32768;
  return std::numeric_limits<int>::max();
}

void NearestPoints::add(const float* q) {
  if (turns_.empty()) {
    add_plain(q);
  } else {
    add_plain(near_zero(q).data());
  }
}

std::vector<float> NearestPoints::near_zero(const float* q) const {
  std::vector<float> result(q, q + dimensions_);
  for (int j = 0; j < dimensions_; ++j) {
    if (turns_[j] > 0.0F) result[j] = std::remainder(q[j], turns_[j]);
  }
  return result;
}

Neighbour NearestPoints::nearest_of_copies(const float* q) const {
  Neighbour best{-1, std::numeric_limits<float>::max()};
  std::vector<float> copy = near_zero(q);
  visit_copies(0, 0.0F, copy, best);
  return best;
}

void NearestPoints::visit_copies(int j, float bound, std::vector<float>& q, Neighbour& best) const {
  while (j < dimensions_ && turns_[j] <= 0.0F) ++j;
  if (j == dimensions_) {
    const Neighbour near = ask(q.data());
    if (near.index < 0 || near.distance2 > best.distance2) return;
    if (near.distance2 < best.distance2 || near.index < best.index || best.index < 0) best = near;
    return;
  }
  visit_copies(j + 1, bound, q, best);
  // All points lie within half a turn of zero: the copy is outside of that by what q is inside of it.
  constexpr float kRoundedDown = 0.999F;
  const float away = std::max(0.0F, 0.5F * turns_[j] - std::abs(q[j]));
  const float farther = bound + away * away;
  if (farther * kRoundedDown > best.distance2) return;
  const float before = q[j];
  q[j] = before > 0.0F ? before - turns_[j] : before + turns_[j];
  visit_copies(j + 1, farther, q, best);
  q[j] = before;
}

void NearestPoints::nearest(const float* q, int count, std::vector<Neighbour>& out) const {
  if (!turns_.empty()) {
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
  if (turns_.empty()) {
    tree_ ? tree_->within(q, radius, out) : all_.within(q, radius, out);
    return;
  }
  const std::vector<float> copy = near_zero(q);
  out.clear();
  for (int i = 0; i < size(); ++i) {
    float sum = 0.0F;
    for (int j = 0; j < dimensions_; ++j) {
      float along = std::abs(copy[j] - all_.coordinate(i, j));
      if (turns_[j] > 0.0F) along = std::min(along, std::abs(turns_[j] - along));
      sum += along * along;
    }
    if (sum < radius * radius) out.push_back({i, sum});
  }
}

void NearestPoints::add_plain(const float* q) {
  all_.add(q);
  if (tree_) {
    tree_->add(q);
  } else if (all_.size() >= worth_a_tree(dimensions_)) {
    tree_.emplace(dimensions_);
    std::vector<float> point(dimensions_);
    for (int i = 0; i < all_.size(); ++i) {
      for (int j = 0; j < dimensions_; ++j) point[j] = all_.coordinate(i, j);
      tree_->add(point.data());
    }
  }
}

}  // namespace hecaton::planner::global
