#pragma once
/// The kernel of nearest-neighbour searches: distances of a point to eight others at a time. Compiled once per
/// instruction set, so this header has no inline code except comparisons.

namespace hecaton::planner::global {

struct Neighbour {
  int index = -1;
  float distance2 = 0.0F;  ///< squared

  /// Nearer, or at the same distance with a smaller index.
  bool operator<(const Neighbour& other) const {
    return distance2 != other.distance2 ? distance2 < other.distance2 : index < other.index;
  }
};

/// `groups`: `count` groups of eight points, coordinate by coordinate. `q`: `dimensions` floats.
struct NearestKernel {
  /// The nearest point, the first one among equals.
  Neighbour (*nearest)(const float* groups, int count, int dimensions, const float* q);
  /// The squared distances of all points, 8 · `count` floats.
  void (*distances2)(const float* groups, int count, int dimensions, const float* q, float* out);
};
namespace baseline {
extern const NearestKernel kNearest;
}
namespace avx2 {
extern const NearestKernel kNearest;
}

}  // namespace hecaton::planner::global
