#include "world/sim/cloud_balls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <vector>

namespace hecaton::world {
namespace {

/// The first reach of a search for the nearest ball; each further one is twice as far [m].
constexpr double kFirstReach = 0.02;
/// Boxes of balls are larger by this, as rounding may cost [m].
constexpr double kBoxRounding = 1e-9;

btVector3 centre_of(const PointCloud& cloud, int number) {
  const Eigen::Vector3f& p = cloud.points()[static_cast<std::size_t>(number)];
  return {static_cast<double>(p.x()), static_cast<double>(p.y()), static_cast<double>(p.z())};
}

}  // namespace

CloudBalls::CloudBalls(std::shared_ptr<const PointCloud> cloud) : cloud_(std::move(cloud)), ball_(cloud_->radius()) {
  const double half = cloud_->radius() + kBoxRounding;
  for (int i = 0; i < static_cast<int>(cloud_->size()); ++i) {
    const btVector3 centre = centre_of(*cloud_, i);
    tree_.put(i, BoundingBox{centre, centre}.grown(half));
  }
}

SignedDistance CloudBalls::distance_from(const btConvexShape& a, const btTransform& X_WA,
                                         const btTransform& X_WS) const {
  const btTransform X_SA = X_WS.inverseTimes(X_WA);
  const BoundingBox box = bounding_box(a, X_SA);
  // No ball is farther than this, however far the cloud is.
  const Eigen::Vector3d middle = from_bullet((box.least + box.greatest) * 0.5);
  const double farthest =
      (middle - cloud_->centre()).norm() + cloud_->bounding_radius() + 0.5 * (box.greatest - box.least).length();
  const auto nearest_within = [&](double reach) {
    SignedDistance best{std::numeric_limits<double>::infinity(), {0.0, 0.0, 1.0}};
    tree_.overlapping(box.grown(reach), [&](int number) {
      const btVector3 centre = centre_of(*cloud_, number);
      if (BoundingBox{centre, centre}.distance(box) - cloud_->radius() >= best.distance) return;
      const SignedDistance found = signed_distance(a, X_SA, ball_, btTransform(btQuaternion::getIdentity(), centre));
      if (found.distance < best.distance) best = found;
    });
    return best;
  };
  double reach = kFirstReach;
  // Balls outside a box grown by `reach` are farther than it.
  SignedDistance best = nearest_within(reach);
  while (best.distance > reach && reach < farthest) {
    reach = std::min({2.0 * reach, best.distance, farthest});
    best = nearest_within(reach);
  }
  best.n_W = X_WS.getBasis() * best.n_W;
  return best;
}

std::optional<double> CloudBalls::cast(const Eigen::Vector3d& p_S, const Eigen::Vector3d& d_S, double range) const {
  std::optional<double> nearest;
  const double radius = cloud_->radius();
  tree_.crossed(to_bullet(p_S), to_bullet(Eigen::Vector3d(p_S + range * d_S)), [&](int number) {
    const Eigen::Vector3d to_centre = from_bullet(centre_of(*cloud_, number)) - p_S;
    const double middle = to_centre.dot(d_S);
    const double across2 = to_centre.squaredNorm() - middle * middle;
    if (across2 > radius * radius) return;
    const double half = std::sqrt(std::max(0.0, radius * radius - across2));
    if (middle + half < 0.0 || middle - half > range) return;
    const double t = std::max(0.0, middle - half);
    if (!nearest || t < *nearest) nearest = t;
  });
  return nearest;
}

std::shared_ptr<const CloudBalls> cloud_balls(const std::shared_ptr<const PointCloud>& cloud) {
  static std::mutex mutex;
  static std::map<const PointCloud*, std::weak_ptr<const CloudBalls>> known;
  const std::lock_guard lock(mutex);
  std::erase_if(known, [](const auto& entry) { return entry.second.expired(); });
  std::shared_ptr<const CloudBalls> balls = known[cloud.get()].lock();
  if (!balls) {
    balls = std::make_shared<const CloudBalls>(cloud);
    known[cloud.get()] = balls;
  }
  return balls;
}

}  // namespace hecaton::world
