#include "world/sim/shape_tree.hpp"

namespace hecaton::world {
namespace {

constexpr double kBoxRounding = 1e-9;  // [m]

}  // namespace

double BoundingBox::distance(const BoundingBox& other) const {
  btVector3 apart = least - other.greatest;
  apart.setMax(other.least - greatest);
  apart.setMax(btVector3(0, 0, 0));
  return apart.length();
}

BoundingBox bounding_box(const btConvexShape& shape, const btTransform& X_WS) {
  BoundingBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const btVector3& along_S = X_WS.getBasis()[axis];
    box.greatest[axis] = X_WS(shape.localGetSupportingVertex(along_S))[axis] + kBoxRounding;
    box.least[axis] = X_WS(shape.localGetSupportingVertex(-along_S))[axis] - kBoxRounding;
  }
  return box;
}

void ShapeTree::clear() {
  tree_->clear();
  leaves_.clear();
}

void ShapeTree::put(int number, const BoundingBox& box, double slack) {
  if (number >= static_cast<int>(leaves_.size())) leaves_.resize(static_cast<std::size_t>(number) + 1, nullptr);
  btDbvtNode*& leaf = leaves_[static_cast<std::size_t>(number)];
  const btDbvtVolume volume = btDbvtVolume::FromMM(box.least, box.greatest);
  if (leaf == nullptr) {
    leaf = tree_->insert(volume, nullptr);
    leaf->dataAsInt = number;
  } else if (!leaf->volume.Contain(volume)) {
    const BoundingBox kept = box.grown(slack);
    btDbvtVolume larger = btDbvtVolume::FromMM(kept.least, kept.greatest);
    tree_->update(leaf, larger);
  }
}

}  // namespace hecaton::world
