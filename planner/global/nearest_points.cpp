#include "planner/global/nearest_points.hpp"

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
