#include "tests/bench/fcl_peer.hpp"

#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/narrowphase/collision_object.h>
#include <fcl/narrowphase/distance.h>

#include "tests/support/fcl_shape.hpp"

namespace hecaton::bench {

using planner::Body;

struct FclPeer::Objects {
  std::vector<std::vector<fcl::CollisionObjectd>> arms;
  std::vector<fcl::CollisionObjectd> boxes;
  fcl::DynamicAABBTreeCollisionManagerd tree;  ///< of all of them; an object's user data is its arm
  fcl::DistanceRequestd request;

  [[nodiscard]] double distance(fcl::CollisionObjectd& own, fcl::CollisionObjectd& other) const {
    fcl::DistanceResultd result;
    return fcl::distance(&own, &other, request, result);
  }
};

namespace {

/// Data of the tree's callback.
struct Query {
  const void* arm = nullptr;
  double influence = 0.0;  ///< [m]
  fcl::DistanceRequestd request;
  std::vector<double>* out = nullptr;
};

/// Callback for each pair that the tree does not exclude. Keeps `nearest` at the influence distance, so that the tree
/// skips farther boxes.
bool add_pair(fcl::CollisionObjectd* one, fcl::CollisionObjectd* two, void* data, double& nearest) {
  const Query& query = *static_cast<Query*>(data);
  nearest = query.influence;
  if (one->getUserData() == query.arm && two->getUserData() == query.arm) return false;
  fcl::DistanceResultd result;
  const double distance = fcl::distance(one, two, query.request, result);
  if (distance < query.influence) query.out->push_back(distance);
  return false;
}

}  // namespace

FclPeer::FclPeer(const planner::CellGeometry& geometry) : geometry_(geometry), objects_(std::make_unique<Objects>()) {
  Objects& all = *objects_;
  all.arms.resize(geometry.arms().size());
  for (std::size_t arm = 0; arm < all.arms.size(); ++arm) {
    for (const Body& body : geometry.arm_bodies(static_cast<int>(arm))) {
      all.arms[arm].emplace_back(test::fcl_shape(body.shape)).setUserData(&all.arms[arm]);
    }
  }
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    all.boxes.emplace_back(test::fcl_shape(geometry.obstacle_bodies(i)[0].shape));
  }
  for (auto& arm : all.arms) {
    for (auto& object : arm) all.tree.registerObject(&object);
  }
  for (auto& box : all.boxes) all.tree.registerObject(&box);
  all.tree.setup();
  all.request.enable_nearest_points = true;
}

FclPeer::~FclPeer() = default;

void FclPeer::place(const Instant& instant) {
  for (std::size_t arm = 0; arm < objects_->arms.size(); ++arm) {
    for (std::size_t i = 0; i < objects_->arms[arm].size(); ++i) {
      const Body& body = geometry_.arm_bodies(static_cast<int>(arm))[i];
      objects_->arms[arm][i].setTransform(instant.kinematics[arm].X_WL[body.link] * body.X_CS);
    }
  }
  for (std::size_t i = 0; i < objects_->boxes.size(); ++i) objects_->boxes[i].setTransform(instant.obstacles[i].X_WO);
}

void FclPeer::distances(int arm, const Instant& instant, std::vector<double>& out) {
  place(instant);
  out.clear();
  auto& own_bodies = objects_->arms[arm];
  for (auto& other_bodies : objects_->arms) {
    if (&other_bodies == &own_bodies) continue;
    for (auto& other : other_bodies) {
      for (auto& own : own_bodies) out.push_back(objects_->distance(own, other));
    }
  }
  for (auto& box : objects_->boxes) {
    for (auto& own : own_bodies) out.push_back(objects_->distance(own, box));
  }
}

void FclPeer::distances_by_tree(int arm, const Instant& instant, double influence, std::vector<double>& out) {
  place(instant);
  for (auto& bodies : objects_->arms) {
    for (auto& body : bodies) body.computeAABB();
  }
  for (auto& box : objects_->boxes) box.computeAABB();
  objects_->tree.update();
  out.clear();
  Query query{&objects_->arms[arm], influence, objects_->request, &out};
  for (auto& own : objects_->arms[arm]) objects_->tree.distance(&own, &query, add_pair);
}

}  // namespace hecaton::bench
