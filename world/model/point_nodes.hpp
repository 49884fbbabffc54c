#pragma once
/// The tree of a point cloud as plain numbers. No inline code: kernels that are compiled once per instruction set read
/// it.

namespace hecaton::world {

/// Children of a node, and points of a leaf: as many as the widest lanes hold.
inline constexpr int kPointFan = 16;

/// Up to sixteen children with axis-aligned boxes around their points [m]. Unused places hold boxes far away.
struct alignas(64) PointNode {
  float low[3][kPointFan];
  float high[3][kPointFan];
  int child[kPointFan];  ///< ≥ 0: index of a node; otherwise ~index of a leaf
  int count;             ///< children
};

/// Up to sixteen points [m]. Unused places repeat the first one.
struct alignas(64) PointLeaf {
  float p[3][kPointFan];
  int count;
};

}  // namespace hecaton::world
