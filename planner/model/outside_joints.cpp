#include "planner/model/outside_joints.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace hecaton::planner {
namespace {

const world::ConvexHull* hull_of(const world::Shape& shape) {
  const auto* convex = std::get_if<world::Convex>(&shape);
  return convex == nullptr ? nullptr : convex->hull.get();
}

/// The body with its joints between `positions`, in the tool frame T.
world::PlacedShape placed(const OutsideBody& body, const std::vector<MotionRange>& positions) {
  const bool held = std::all_of(body.steps.begin(), body.steps.end(), [&](const MechanismStep& step) {
    return !step.moves || positions[step.joint].lower == positions[step.joint].upper;
  });
  std::vector<double> lower;
  for (const MotionRange& position : positions) lower.push_back(position.lower);
  if (held) return {body.shape, body.X_TP * place_of(body.steps, lower) * body.X_LS};
  auto hull = around_places(body.steps, positions, body.shape, body.X_LS);
  // The shape was enclosed for the whole range when the model was loaded, and so it can be for a part of it.
  return {world::Convex{std::make_shared<const world::ConvexHull>(std::move(hull.value()))}, body.X_TP};
}

}  // namespace

const OutsideBody* outside_body(const RobotModel& model, const world::Shape& shape) {
  const world::ConvexHull* hull = hull_of(shape);
  if (!model.outside || hull == nullptr) return nullptr;
  const auto& bodies = model.outside->bodies;
  const auto found =
      std::find_if(bodies.begin(), bodies.end(), [&](const OutsideBody& body) { return body.enclosure.get() == hull; });
  return found == bodies.end() ? nullptr : &*found;
}

std::vector<MotionRange> outside_ranges(const RobotModel& model) {
  std::vector<MotionRange> ranges;
  if (!model.outside) return ranges;
  for (const OutsideJoint& joint : model.outside->joints) ranges.push_back(joint.range);
  return ranges;
}

std::shared_ptr<const RobotModel> without_outside_bodies(std::shared_ptr<const RobotModel> model) {
  if (!model->outside || model->outside->bodies.empty()) return model;
  const auto reduced = std::make_shared<RobotModel>(*model);
  reduced->geometry.clear();
  std::map<int, int> index_of;  // in `reduced`, by that in `model`
  for (int g = 0; g < static_cast<int>(model->geometry.size()); ++g) {
    if (outside_body(*model, model->geometry[g].shape) != nullptr) continue;
    index_of[g] = static_cast<int>(reduced->geometry.size());
    reduced->geometry.push_back(model->geometry[g]);
  }
  reduced->self_pairs.clear();
  for (const auto& [a, b] : model->self_pairs) {
    if (index_of.contains(a) && index_of.contains(b)) reduced->self_pairs.emplace_back(index_of[a], index_of[b]);
  }
  reduced->close_pairs.clear();
  for (const ClosePair& pair : model->close_pairs) {
    if (!index_of.contains(pair.first) || !index_of.contains(pair.second)) continue;
    reduced->close_pairs.push_back({index_of[pair.first], index_of[pair.second], pair.widest});
  }
  return reduced;
}

std::vector<world::Obstacle> outside_obstacles(const Arm& arm, std::span<const MotionRange> positions) {
  std::vector<world::Obstacle> obstacles;
  if (!arm.model->outside) return obstacles;
  const std::vector<MotionRange> at(positions.begin(), positions.end());
  for (const OutsideBody& body : arm.model->outside->bodies) {
    const auto same = std::find_if(obstacles.begin(), obstacles.end(),
                                   [&](const world::Obstacle& obstacle) { return obstacle.name == body.link; });
    world::Obstacle& obstacle = same != obstacles.end() ? *same : obstacles.emplace_back();
    obstacle.name = body.link;
    obstacle.attachment = world::Attachment{arm.name, Pose::Identity()};
    obstacle.shapes.push_back(placed(body, at));
  }
  return obstacles;
}

std::vector<Pose> outside_places(const RobotModel& model, const std::vector<double>& positions) {
  std::vector<Pose> places;
  if (!model.outside) return places;
  for (const OutsideBody& body : model.outside->bodies) {
    places.push_back(body.X_TP * place_of(body.steps, positions));
  }
  return places;
}

}  // namespace hecaton::planner
