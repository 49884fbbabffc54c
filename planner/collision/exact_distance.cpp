#include "planner/collision/exact_distance.hpp"

#include <algorithm>
#include <vector>

#include "planner/collision/convex_distance.hpp"
#include "planner/collision/primitive_distance.hpp"
#include "planner/collision/swept_core.hpp"

namespace hecaton::planner {
namespace {

Segment segment(const SweptCore& core, const Pose& X_WS) {
  const Eigen::Vector3d half = core.half.z() * X_WS.linear().col(2);
  return {X_WS.translation() - half, X_WS.translation() + half};
}

ShapeDistance core_distance(const SweptCore& a, const Pose& X_WA, const SweptCore& b, const Pose& X_WB) {
  const bool a_is_thin = a.core <= Core::kSegment;
  const bool b_is_thin = b.core <= Core::kSegment;
  if (a_is_thin && b_is_thin) return segment_segment(segment(a, X_WA), segment(b, X_WB));
  if (b_is_thin) return exchanged(core_distance(b, X_WB, a, X_WA));
  if (a_is_thin && b.core == Core::kBox) return segment_box(segment(a, X_WA), b.half, X_WB);
  if (a.core == Core::kPoint && b.core == Core::kCylinder) {
    return point_cylinder(X_WA.translation(), b.half.x(), b.half.z(), X_WB);
  }
  return convex_distance(a, X_WA, b, X_WB);
}

ShapeDistance distance(const SweptCore& a, const Pose& X_WA, const SweptCore& b, const Pose& X_WB) {
  return swept(core_distance(a, X_WA, b, X_WB), a.radius, b.radius);
}

/// Room for one more in a full list: drops the farthest clearance if it is farther than `distance`, keeps the order.
bool drop_farthest(std::span<Clearance> full, double distance) {
  const auto farthest = std::max_element(
      full.begin(), full.end(), [](const Clearance& a, const Clearance& b) { return a.distance < b.distance; });
  if (farthest == full.end() || distance >= farthest->distance) return false;
  std::move(farthest + 1, full.end(), farthest);
  return true;
}

}  // namespace

struct ExactDistance::Storage {
  explicit Storage(const CellGeometry& geometry) : near(geometry) {
    for (const CellBody& body : near.bodies()) {
      const auto& bodies = body.counterpart == Counterpart::kObstacle ? geometry.obstacle_bodies(body.owner)
                                                                      : geometry.arm_bodies(body.owner);
      cores.push_back(make_swept_core(bodies[body.index].shape));
    }
  }

  NearPairs near;
  std::vector<SweptCore> cores;  ///< one per body of `near`
};

ExactDistance::ExactDistance(const CellGeometry& geometry) : storage_(std::make_unique<Storage>(geometry)) {}
ExactDistance::~ExactDistance() = default;
ExactDistance::ExactDistance(ExactDistance&&) noexcept = default;
ExactDistance& ExactDistance::operator=(ExactDistance&&) noexcept = default;

void ExactDistance::rebuild(const CellGeometry& geometry) {
  storage_ = std::make_unique<Storage>(geometry);
}

int ExactDistance::clearances(const CellPoses& poses, const InfluenceDistances& influence, std::span<Clearance> out) {
  NearPairs& near = storage_->near;
  const auto& cores = storage_->cores;
  int count = 0;
  for (const NearPair& pair : near.find(poses, influence)) {
    const ShapeDistance exact =
        distance(cores[pair.own], near.pose(pair.own), cores[pair.other], near.pose(pair.other));
    if (exact.distance >= pair.limit) continue;
    if (count == static_cast<int>(out.size())) {
      if (!drop_farthest(out, exact.distance)) continue;
      --count;
    }
    const CellBody& own = near.bodies()[pair.own];
    const CellBody& other = near.bodies()[pair.other];
    out[count++] = {own.index,  own.link,       other.counterpart, other.owner, other.index,
                    other.link, exact.distance, exact.p_a_W,       exact.p_b_W, exact.n_W};
  }
  return count;
}

ShapeDistance shape_distance(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
  return distance(make_swept_core(a), X_WA, make_swept_core(b), X_WB);
}

}  // namespace hecaton::planner
