#pragma once
/// Broad phase: a tree of boxes around shapes. Two readers may query it at the same time.

#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvt.h>

#include "world/sim/bullet_shape.hpp"

namespace hecaton::world {

/// A box along the axes of W that encloses a shape.
struct BoundingBox {
  btVector3 least;     ///< [m]
  btVector3 greatest;  ///< [m]

  /// No points of the two boxes are nearer to each other [m]; 0 where they overlap.
  [[nodiscard]] double distance(const BoundingBox& other) const;
  [[nodiscard]] BoundingBox grown(double by) const {
    const btVector3 all(by, by, by);
    return {least - all, greatest + all};
  }
};

/// The smallest box of the shape, larger by rounding only.
[[nodiscard]] BoundingBox bounding_box(const btConvexShape& shape, const btTransform& X_WS);

/// Boxes with numbers. Numbers are indices: memory grows with the greatest.
class ShapeTree {
 public:
  void clear();
  /// Adds box `number`, or moves it. The tree keeps a moved box larger by `slack` [m], and changes only when the box
  /// leaves that.
  void put(int number, const BoundingBox& box, double slack = 0.0);

  /// Calls visit(number) for each box that overlaps `box`, and perhaps for some near it, in any order.
  template <typename Visit>
  void overlapping(const BoundingBox& box, const Visit& visit) const {
    if (tree_->m_root == nullptr) return;
    Visitor<Visit> visitor(visit);
    btDbvtVolume volume = btDbvtVolume::FromMM(box.least, box.greatest);
    tree_->collideTV(tree_->m_root, volume, visitor);
  }
  /// Calls visit(number) for each box that the segment crosses, and perhaps for some near it, in any order.
  template <typename Visit>
  void crossed(const btVector3& from_W, const btVector3& to_W, const Visit& visit) const {
    if (tree_->m_root == nullptr) return;
    Visitor<Visit> visitor(visit);
    btDbvt::rayTest(tree_->m_root, from_W, to_W, visitor);
  }

 private:
  template <typename Visit>
  struct Visitor final : btDbvt::ICollide {
    explicit Visitor(const Visit& visit_given) : visit(visit_given) {}
    void Process(const btDbvtNode* leaf) override { visit(leaf->dataAsInt); }
    const Visit& visit;
  };

  std::unique_ptr<btDbvt> tree_ = std::make_unique<btDbvt>();
  std::vector<btDbvtNode*> leaves_;  ///< of each number; null: not put
};

}  // namespace hecaton::world
