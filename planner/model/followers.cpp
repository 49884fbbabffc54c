#include "planner/model/followers.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "planner/model/convex_hull.hpp"
#include "planner/model/kinematics.hpp"
#include "planner/model/mesh_shape.hpp"
#include "planner/model/outside_joints.hpp"
#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

constexpr double kStep = 0.05;       // largest angle between two sampled places [rad]
constexpr int kMostSamples = 256;    // of one joint
constexpr double kFarthest = 100.0;  // of a follower's shape [m]

/// Vertices of a polyhedron that encloses the shape, in S.
std::vector<Eigen::Vector3d> enclosing_vertices(const world::Shape& shape) {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  if (const auto* convex = std::get_if<world::Convex>(&shape)) return convex->hull->vertices;
  if (const auto* box = std::get_if<world::Box>(&shape)) half = box->half_extents;
  if (const auto* sphere = std::get_if<world::Sphere>(&shape)) half.setConstant(sphere->radius);
  if (const auto* capsule = std::get_if<world::Capsule>(&shape)) {
    half << capsule->radius, capsule->radius, capsule->half_length + capsule->radius;
  }
  if (const auto* cylinder = std::get_if<world::Cylinder>(&shape)) {
    half << cylinder->radius, cylinder->radius, cylinder->half_length;
  }
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    corners.emplace_back((i & 1) != 0 ? half.x() : -half.x(), (i & 2) != 0 ? half.y() : -half.y(),
                         (i & 4) != 0 ? half.z() : -half.z());
  }
  return corners;
}

Pose motion(const MechanismStep& step, const std::vector<double>& q) {
  if (!step.moves) return step.held;
  const double position = step.multiplier * q[step.joint] + step.offset;
  Pose X = step.X_PJ;
  if (step.type == JointType::kPrismatic) {
    X.translate(position * step.axis);
  } else {
    X.rotate(Eigen::AngleAxisd(position, step.axis));
  }
  return X;
}

std::set<int> joints_of(const std::vector<MechanismStep>& steps) {
  std::set<int> joints;
  for (const MechanismStep& step : steps) {
    if (step.moves) joints.insert(step.joint);
  }
  return joints;
}

/// The places of a link of a mechanism, in the frame of the link that carries it.
class Sweep {
 public:
  /// `limits`: by MechanismStep::joint.
  Sweep(const std::vector<MechanismStep>& steps, const std::vector<MotionRange>& limits)
      : steps_(steps), limits_(limits), joints_(joints_of(steps)) {}

  [[nodiscard]] std::optional<world::ConvexHull> around(const world::Shape& shape, const Pose& X_LS) const {
    std::vector<Eigen::Vector3d> corners = enclosing_vertices(shape);
    for (Eigen::Vector3d& p : corners) p = X_LS * p;
    // Between two samples a point deviates from the straight line by at most δ² |p″| / 8. The
    // acceleration p″ has two parts: the squared sum of all rates times the greatest distance from a joint, and twice
    // the product of turning and sliding rates.
    double lever = 0.0;
    std::vector<Eigen::Vector3d> points;
    const std::vector<int> joints(joints_.begin(), joints_.end());
    const int count0 = samples(joints[0]);
    const int count1 = joints.size() > 1 ? samples(joints[1]) : 1;
    std::vector<double> q(limits_.size(), 0.0);
    for (int a = 0; a < count0; ++a) {
      q[joints[0]] = sample(joints[0], a, count0);
      for (int b = 0; b < count1; ++b) {
        if (joints.size() > 1) q[joints[1]] = sample(joints[1], b, count1);
        const Pose X_PL = place_of(steps_, q);
        for (const Eigen::Vector3d& p : corners) points.emplace_back(X_PL * p);
        lever = std::max(lever, greatest_lever(q, points, points.size() - corners.size()));
      }
    }
    double margin = 0.0;
    for (const int joint : joints) {
      const double step = range(joint) / (samples(joint) - 1);
      const double turn = rate(joint, false);
      const double slide = rate(joint, true);
      margin += step * step / 8.0 * (turn * turn * 1.05 * lever + 2.0 * turn * slide);
    }
    margin = std::max(margin, 1e-6);
    std::vector<Eigen::Vector3d> widened;
    for (const Eigen::Vector3d& p : points) {
      for (const Eigen::Vector3d& corner : enclosing_vertices(world::Sphere{margin})) {
        widened.emplace_back(p + corner);
      }
    }
    const bool is_near = std::all_of(widened.begin(), widened.end(), [](const Eigen::Vector3d& p) {
      return p.allFinite() && p.cwiseAbs().maxCoeff() < kFarthest;
    });
    const auto hull = is_near ? convex_hull(widened) : std::nullopt;
    if (!hull) return std::nullopt;
    return enclosing_hull(*hull, kMaxHullVertices);
  }

 private:
  [[nodiscard]] double multiplier_sum(int joint) const {
    double sum = 0.0;
    for (const MechanismStep& step : steps_) {
      if (step.moves && step.joint == joint) sum += std::abs(step.multiplier);
    }
    return sum;
  }
  /// The sum of the rates of turning or sliding followers per unit of the joint.
  [[nodiscard]] double rate(int joint, bool slides) const {
    double sum = 0.0;
    for (const MechanismStep& step : steps_) {
      if (!step.moves || step.joint != joint) continue;
      if ((step.type == JointType::kPrismatic) == slides) sum += std::abs(step.multiplier);
    }
    return sum;
  }
  [[nodiscard]] bool is_endless(int joint) const { return !std::isfinite(limits_[joint].lower); }
  [[nodiscard]] double lowest(int joint) const {
    return is_endless(joint) ? -0.5 * range(joint) : limits_[joint].lower;
  }
  /// A joint without limits takes its followers once around.
  [[nodiscard]] double range(int joint) const {
    if (!is_endless(joint)) return limits_[joint].upper - limits_[joint].lower;
    double slowest = 1.0;
    for (const MechanismStep& step : steps_) {
      if (step.moves && step.joint == joint && step.multiplier != 0.0) {
        slowest = std::min(slowest, std::abs(step.multiplier));
      }
    }
    return 2.0 * std::numbers::pi / slowest;
  }
  [[nodiscard]] int samples(int joint) const {
    const int most = joints_.size() > 1 ? 32 : kMostSamples;
    const double steps = std::ceil(range(joint) * multiplier_sum(joint) / kStep);
    return steps < most ? std::max(2, static_cast<int>(steps) + 1) : most;  // most also for NaN
  }
  [[nodiscard]] double sample(int joint, int i, int count) const {
    return lowest(joint) + range(joint) * i / (count - 1);
  }
  /// The greatest distance of a point from the origin of a follower's joint.
  [[nodiscard]] double greatest_lever(const std::vector<double>& q, const std::vector<Eigen::Vector3d>& points,
                                      std::size_t first) const {
    double greatest = 0.0;
    Pose X = Pose::Identity();
    for (const MechanismStep& step : steps_) {
      X = X * motion(step, q);
      if (!step.moves) continue;
      for (std::size_t i = first; i < points.size(); ++i) {
        greatest = std::max(greatest, (points[i] - X.translation()).norm());
      }
    }
    return greatest;
  }

  const std::vector<MechanismStep>& steps_;
  const std::vector<MotionRange>& limits_;
  std::set<int> joints_;
};

/// The way of a link's mechanism from the link that carries it; empty: the link does not move with one.
std::vector<MechanismStep> mechanism_of(const std::vector<Follower>& followers, const RobotModel& model, int link) {
  std::vector<MechanismStep> steps;
  for (int i = link; i >= 0 && model.links[i].joint < 0; i = model.links[i].parent) {
    const Link& at = model.links[i];
    MechanismStep step;
    step.held = at.X_PJ;
    const auto follower =
        std::find_if(followers.begin(), followers.end(), [&](const Follower& one) { return one.link == i; });
    if (follower != followers.end()) {
      step = {true,    at.X_PJ,         follower->X_PJ,       follower->type,
              at.axis, follower->joint, follower->multiplier, follower->offset};
    }
    steps.insert(steps.begin(), step);
  }
  // Links before the first follower do not move with the mechanism.
  const auto first = std::find_if(steps.begin(), steps.end(), [](const MechanismStep& step) { return step.moves; });
  steps.erase(steps.begin(), first);
  return steps;
}

/// The polyhedron in another frame.
world::ConvexHull moved(world::ConvexHull hull, const Pose& X) {
  for (Eigen::Vector3d& vertex : hull.vertices) vertex = X * vertex;
  return hull;
}

/// The last link in the frame of the link that carries the mechanism, where the model holds it.
Pose held_place(const std::vector<MechanismStep>& steps) {
  Pose X = Pose::Identity();
  for (const MechanismStep& step : steps) X = X * step.held;
  return X;
}

/// A link in the frame of the link that carries it; −1: the root. No joint is between them. The model may still have
/// more links than Kinematics.
Pose place_on(const RobotModel& model, int carrier, int link) {
  Pose X = Pose::Identity();
  for (int i = link; i != carrier && i > 0; i = model.links[i].parent) X = model.links[i].X_PJ * X;
  return X;
}

/// The body of a range's joints alone that the tool's body carries; empty: it is another one.
std::optional<OutsideBody> body_of_tool(const RobotModel& model, const LinkGeometry& geometry,
                                        const std::vector<MechanismStep>& steps) {
  const int tool = model.tool_link;
  const int carrier = moved_link(model, tool);
  if (moved_link(model, geometry.link) != carrier) return std::nullopt;
  OutsideBody body{model.links[geometry.link].name, nullptr, geometry.shape, geometry.X_LS, Pose::Identity(), {}};
  for (MechanismStep step : steps) {
    if (step.moves && step.joint < model.joints()) return std::nullopt;
    step.joint -= step.moves ? model.joints() : 0;
    body.steps.push_back(step);
  }
  const Pose X_CP = place_on(model, carrier, geometry.link) * held_place(steps).inverse();
  body.X_TP = (place_on(model, carrier, tool) * model.X_LT).inverse() * X_CP;
  return body;
}

JointType type_of(const std::vector<Follower>& followers, int joint) {
  for (const Follower& follower : followers) {
    if (follower.joint == joint && follower.multiplier == 1.0 && follower.offset == 0.0) return follower.type;
  }
  return JointType::kRevolute;
}

}  // namespace

std::optional<world::ConvexHull> around_places(const std::vector<MechanismStep>& steps,
                                               const std::vector<MotionRange>& ranges, const world::Shape& shape,
                                               const Pose& X_LS) {
  return Sweep(steps, ranges).around(shape, X_LS);
}

Pose place_of(const std::vector<MechanismStep>& steps, const std::vector<double>& positions) {
  Pose X = Pose::Identity();
  for (const MechanismStep& step : steps) X = X * motion(step, positions);
  return X;
}

void enclose_followers(const std::vector<Follower>& followers, const std::vector<MotionRange>& ranges,
                       const std::string& path, RobotModel& model, const std::vector<std::string>& joint_names) {
  if (followers.empty()) return;
  std::vector<MotionRange> limits;  // by Follower::joint
  for (int j = 0; j < model.joints(); ++j) limits.push_back({model.limits.lower[j], model.limits.upper[j]});
  limits.insert(limits.end(), ranges.begin(), ranges.end());
  const auto outside = std::make_shared<OutsideJoints>();
  for (std::size_t i = 0; i < joint_names.size(); ++i) {
    outside->joints.push_back({joint_names[i], type_of(followers, model.joints() + static_cast<int>(i)), ranges[i]});
  }
  std::set<std::string> names;
  for (int g = 0; g < static_cast<int>(model.geometry.size()); ++g) {
    LinkGeometry& geometry = model.geometry[g];
    const std::vector<MechanismStep> steps = mechanism_of(followers, model, geometry.link);
    if (steps.empty()) continue;
    const std::set<int> joints = joints_of(steps);
    const std::string& name = model.links[geometry.link].name;
    if (joints.size() > 2) {
      std::string list;
      for (const int joint : joints) {
        const int range = joint - model.joints();
        list += (list.empty() ? "" : ", ") + in_quotes(range < 0 ? model.joint_names[joint] : joint_names[range]);
      }
      throw ModelError(path + ": link " + in_quotes(name) + " moves with joints " + list + "; at most two may move it" +
                       (ranges.empty() ? "" : ": give the others one position in place of a range"));
    }
    const auto hull = around_places(steps, limits, geometry.shape, geometry.X_LS);
    if (!hull) {
      throw ModelError(path + ": link " + in_quotes(name) +
                       " follows a joint of the chain farther than 100 m; check the multipliers of its mimic joints");
    }
    auto body = body_of_tool(model, geometry, steps);
    const double before = volume(geometry.shape);
    const auto enclosure = std::make_shared<const world::ConvexHull>(moved(*hull, held_place(steps).inverse()));
    geometry.shape = world::Convex{enclosure};
    geometry.X_LS = Pose::Identity();
    geometry.excess_volume = volume(geometry.shape) / before - 1.0;
    geometry.capsule = link_capsule(geometry.shape);
    std::erase_if(model.self_pairs, [&](const std::pair<int, int>& pair) {
      if (pair.first != g && pair.second != g) return false;
      const int moved = moved_link(model, model.geometry[pair.first == g ? pair.second : pair.first].link);
      return moved >= 0 && joints.contains(model.links[moved].joint);
    });
    names.insert(name);
    for (const int joint : joints) {
      const bool has_range = joint >= model.joints();  // else it is a joint of the chain, which the link follows
      if (!has_range || moved_link(model, geometry.link) >= 0) continue;
      outside->joints[static_cast<std::size_t>(joint - model.joints())].of_base = true;
    }
    if (!body || joint_names.empty()) continue;
    body->enclosure = enclosure;
    for (const int joint : joints) outside->joints[static_cast<std::size_t>(joint - model.joints())].of_tool = true;
    outside->bodies.push_back(std::move(*body));
  }
  if (!outside->joints.empty()) model.outside = outside;
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + in_quotes(name);
  if (!list.empty()) {
    model.notes.push_back(std::string("links beside the chain follow its joints") +
                          (ranges.empty() ? "" : " or move within their ranges") +
                          "; their shapes enclose all places where they may be: " + list);
  }
}

}  // namespace hecaton::planner
