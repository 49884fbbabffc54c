#include "world/sim/pushing.hpp"

#include <algorithm>
#include <cmath>

namespace hecaton::world {
namespace {

constexpr double kMaxSubstep = 0.005;  // [s]

}  // namespace

bool is_free(const Obstacle& obstacle) {
  return !obstacle.attachment && std::holds_alternative<DynamicMotion>(obstacle.motion);
}

void Pushing::advance(const Surroundings& around, std::span<MotionState> states, double dt) {
  const auto& obstacles = around.scene.obstacles;
  if (dt <= 0.0 || std::none_of(obstacles.begin(), obstacles.end(), is_free)) return;
  make_missing(around, states);

  // A dt of a whole number of substeps must not get one more by rounding.
  const int substeps = std::max(1, static_cast<int>(std::ceil(dt / kMaxSubstep - 1e-9)));
  const double h = dt / substeps;
  for (int i = 0; i < substeps; ++i) {
    place(around, dt, i * h, h);
    space_->step(h);
  }
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    if (is_free(obstacles[i])) states[i] = bodies_[i]->state();
  }
}

void Pushing::make_missing(const Surroundings& around, std::span<const MotionState> states) {
  if (!space_) space_ = std::make_unique<PhysicsSpace>(around.scene.floor_z, around.scene.gravity);
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Obstacle& obstacle = around.scene.obstacles[i];
    if (bodies_[i]) continue;
    if (is_free(obstacle)) {
      const auto& motion = std::get<DynamicMotion>(obstacle.motion);
      bodies_[i] = std::make_unique<RigidBody>(*space_, obstacle.shapes, motion, states[i]);
    } else if (!obstacle.attachment || around.carriers[i]->known()) {
      bodies_[i] = std::make_unique<RigidBody>(*space_, obstacle.shapes, states[i].X_WO);
    }
  }
  arm_bodies_.resize(around.arms.size());
  for (std::size_t arm = 0; arm < around.arms.size(); ++arm) {
    if (!around.tracks[arm].known() || !arm_bodies_[arm].empty()) continue;
    for (const auto& part : around.arms[arm].parts) {
      arm_bodies_[arm].push_back(
          std::make_unique<RigidBody>(*space_, std::span(&part.shape, 1), around.tracks[arm].X_WL()[part.link]));
    }
  }
}

void Pushing::place(const Surroundings& around, double dt, double elapsed, double h) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Obstacle& obstacle = around.scene.obstacles[i];
    if (!bodies_[i] || is_free(obstacle)) continue;
    bodies_[i]->place(obstacle.attachment ? carried(around.carriers[i]->tool_at(dt, elapsed), obstacle.attachment->X_TO)
                                          : motion_at(obstacle, around.time + elapsed),
                      h);
  }
  for (std::size_t arm = 0; arm < arm_bodies_.size(); ++arm) {
    for (std::size_t part = 0; part < arm_bodies_[arm].size(); ++part) {
      const int link = around.arms[arm].parts[part].link;
      arm_bodies_[arm][part]->place(around.tracks[arm].link_at(link, dt, elapsed), h);
    }
  }
}

}  // namespace hecaton::world
