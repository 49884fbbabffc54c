#pragma once
/// Contacts and smallest separation between moving parts and obstacles, pair by pair: what the contact monitor must
/// report, without its bounds and broad phase.

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "world/sim/bullet_shape.hpp"
#include "world/sim/contact_monitor.hpp"

namespace hecaton::world {

class PairwiseContacts {
 public:
  /// Pairs each moving part of the arms with each shape of the obstacles.
  PairwiseContacts(std::span<const ArmBodies> arms, std::span<const Obstacle> obstacles) {
    for (std::size_t arm = 0; arm < arms.size(); ++arm) {
      for (const ArmBodies::Part& part : arms[arm].parts) {
        if (!part.moves) continue;
        links_.push_back({static_cast<int>(arm), part.link, arms[arm].name + "/" + part.link_name, body(part.shape)});
      }
    }
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
      for (const PlacedShape& shape : obstacles[i].shapes) {
        targets_.push_back({static_cast<int>(i), 0, obstacles[i].name, body(shape)});
      }
    }
    touching_.assign(links_.size() * targets_.size(), false);
  }

  /// Computes every distance, or only those that may be new minima or contacts: `bounded` by spheres.
  void update(std::span<const MeasuredArm> arms, std::span<const ObstacleState> obstacles, double time, bool bounded) {
    for (Part& link : links_) link.body.place(arms[static_cast<std::size_t>(link.owner)].X_WL[link.link]);
    for (Part& target : targets_) target.body.place(obstacles[static_cast<std::size_t>(target.owner)].X_WO);
    std::size_t pair = 0;
    for (const Part& target : targets_) {
      for (const Part& link : links_) check(link, target, pair++, time, bounded);
    }
  }

  [[nodiscard]] const Separation& smallest() const { return smallest_; }
  /// Begun touching pairs of shapes.
  [[nodiscard]] std::span<const Separation> contacts() const { return contacts_; }

 private:
  struct Body {
    std::shared_ptr<const btConvexShape> shape;
    Pose X_CS = Pose::Identity();
    BoundingSphere bound;
    Eigen::Vector3d centre_W = Eigen::Vector3d::Zero();
    btTransform X_WS;

    void place(const Pose& X_WC) {
      X_WS = to_bullet(X_WC * X_CS);
      centre_W = X_WC * (X_CS * bound.centre);
    }
  };
  struct Part {
    int owner = 0;
    int link = 0;
    std::string name;
    Body body;
  };

  static Body body(const PlacedShape& placed) {
    return {make_bullet_shape(placed.shape), placed.X_BS, bounding_sphere(placed.shape), {}, {}};
  }

  void check(const Part& link, const Part& target, std::size_t pair, double time, bool bounded) {
    const double spheres =
        (link.body.centre_W - target.body.centre_W).norm() - link.body.bound.radius - target.body.bound.radius;
    if (bounded && spheres > 0.0 && spheres >= smallest_.distance && !touching_[pair]) return;
    const double distance =
        signed_distance(*link.body.shape, link.body.X_WS, *target.body.shape, target.body.X_WS).distance;
    const Separation found{distance, ContactKind::kArmObstacle, link.name, target.name, time};
    if (distance < smallest_.distance) smallest_ = found;
    if (!touching_[pair] && distance <= 0.0) contacts_.push_back(found);
    if (distance <= 0.0 || distance > kPartedDistance) touching_[pair] = distance <= 0.0;
  }

  std::vector<Part> links_;
  std::vector<Part> targets_;
  std::vector<bool> touching_;
  Separation smallest_{std::numeric_limits<double>::infinity(), ContactKind::kArmObstacle, {}, {}, 0.0};
  std::vector<Separation> contacts_;
};

}  // namespace hecaton::world
