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

/// The places of one link that followers move.
class Sweep {
 public:
  Sweep(const std::vector<Follower>& followers, const std::vector<MotionRange>& ranges, const RobotModel& model,
        int link)
      : model_(model), ranges_(ranges) {
    for (int i = link; i >= 0 && model.links[i].joint < 0; i = model.links[i].parent) {
      const auto follower =
          std::find_if(followers.begin(), followers.end(), [&](const Follower& one) { return one.link == i; });
      path_.insert(path_.begin(), Step{i, follower == followers.end() ? nullptr : &*follower});
    }
    // Links before the first follower do not move with the mechanism.
    const auto first =
        std::find_if(path_.begin(), path_.end(), [](const Step& step) { return step.follower != nullptr; });
    path_.erase(path_.begin(), first);
    for (const Step& step : path_) {
      if (step.follower != nullptr) joints_.insert(step.follower->joint);
    }
  }

  [[nodiscard]] bool moves() const { return !path_.empty(); }
  [[nodiscard]] const std::set<int>& joints() const { return joints_; }

  /// A polyhedron, in the link's frame, around all places of a shape of the link. Empty if it gets too far.
  [[nodiscard]] std::optional<world::ConvexHull> around(const LinkGeometry& geometry) const {
    std::vector<Eigen::Vector3d> corners = enclosing_vertices(geometry.shape);
    for (Eigen::Vector3d& p : corners) p = geometry.X_LS * p;
    // Between two samples a point deviates from the straight line by at most δ² |p″| / 8. The
    // acceleration p″ has two parts: the squared sum of all rates times the greatest distance from a joint, and twice
    // the product of turning and sliding rates.
    double lever = 0.0;
    std::vector<Eigen::Vector3d> points;
    const std::vector<int> joints(joints_.begin(), joints_.end());
    const int count0 = samples(joints[0]);
    const int count1 = joints.size() > 1 ? samples(joints[1]) : 1;
    Positions q(model_.joints() + ranges_.size(), 0.0);
    const Pose X_LP = held_pose().inverse();
    for (int a = 0; a < count0; ++a) {
      q[joints[0]] = sample(joints[0], a, count0);
      for (int b = 0; b < count1; ++b) {
        if (joints.size() > 1) q[joints[1]] = sample(joints[1], b, count1);
        const Pose X_PL = pose(q);
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
        widened.emplace_back(X_LP * (p + corner));
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
  using Positions = std::vector<double>;  ///< of the chain's joints, then of those with a range

  struct Step {
    int link;
    const Follower* follower;  ///< null: fixed
  };

  [[nodiscard]] double multiplier_sum(int joint) const {
    double sum = 0.0;
    for (const Step& step : path_) {
      if (step.follower != nullptr && step.follower->joint == joint) sum += std::abs(step.follower->multiplier);
    }
    return sum;
  }
  /// The sum of the rates of turning or sliding followers per unit of the joint.
  [[nodiscard]] double rate(int joint, bool slides) const {
    double sum = 0.0;
    for (const Step& step : path_) {
      if (step.follower == nullptr || step.follower->joint != joint) continue;
      if ((step.follower->type == JointType::kPrismatic) == slides) sum += std::abs(step.follower->multiplier);
    }
    return sum;
  }
  [[nodiscard]] MotionRange limits(int joint) const {
    if (joint >= model_.joints()) return ranges_[joint - model_.joints()];
    return {model_.limits.lower[joint], model_.limits.upper[joint]};
  }
  [[nodiscard]] bool is_endless(int joint) const { return !std::isfinite(limits(joint).lower); }
  [[nodiscard]] double lowest(int joint) const { return is_endless(joint) ? -0.5 * range(joint) : limits(joint).lower; }
  /// A joint without limits takes its followers once around.
  [[nodiscard]] double range(int joint) const {
    if (!is_endless(joint)) return limits(joint).upper - limits(joint).lower;
    double slowest = 1.0;
    for (const Step& step : path_) {
      if (step.follower != nullptr && step.follower->joint == joint && step.follower->multiplier != 0.0) {
        slowest = std::min(slowest, std::abs(step.follower->multiplier));
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
  /// pose() at the positions at which the model holds the followers.
  [[nodiscard]] Pose held_pose() const {
    Pose X = Pose::Identity();
    for (const Step& step : path_) X = X * model_.links[step.link].X_PJ;
    return X;
  }

  [[nodiscard]] Pose motion(const Step& step, const Positions& q) const {
    if (step.follower == nullptr) return model_.links[step.link].X_PJ;
    const Follower& follower = *step.follower;
    const double position = follower.multiplier * q[follower.joint] + follower.offset;
    Pose X = follower.X_PJ;
    const Eigen::Vector3d& axis = model_.links[step.link].axis;
    if (follower.type == JointType::kPrismatic) {
      X.translate(position * axis);
    } else {
      X.rotate(Eigen::AngleAxisd(position, axis));
    }
    return X;
  }
  /// The link in the frame of the link P that carries the first follower.
  [[nodiscard]] Pose pose(const Positions& q) const {
    Pose X = Pose::Identity();
    for (const Step& step : path_) X = X * motion(step, q);
    return X;
  }
  /// The greatest distance of a point from the origin of a follower's joint.
  [[nodiscard]] double greatest_lever(const Positions& q, const std::vector<Eigen::Vector3d>& points,
                                      std::size_t first) const {
    double greatest = 0.0;
    Pose X = Pose::Identity();
    for (const Step& step : path_) {
      X = X * motion(step, q);
      if (step.follower == nullptr) continue;
      for (std::size_t i = first; i < points.size(); ++i) {
        greatest = std::max(greatest, (points[i] - X.translation()).norm());
      }
    }
    return greatest;
  }

  const RobotModel& model_;
  const std::vector<MotionRange>& ranges_;
  std::vector<Step> path_;  ///< from the first follower to the link
  std::set<int> joints_;    ///< Follower::joint that move the link in the frame of the link that carries the mechanism
};

}  // namespace

void enclose_followers(const std::vector<Follower>& followers, const std::vector<MotionRange>& ranges,
                       const std::string& path, RobotModel& model) {
  if (followers.empty()) return;
  std::set<std::string> names;
  for (int g = 0; g < static_cast<int>(model.geometry.size()); ++g) {
    LinkGeometry& geometry = model.geometry[g];
    const Sweep sweep(followers, ranges, model, geometry.link);
    if (!sweep.moves()) continue;
    const std::string& name = model.links[geometry.link].name;
    if (sweep.joints().size() > 2) {
      throw ModelError(path + ": link " + in_quotes(name) + " follows more than two joints; this is not supported");
    }
    auto hull = sweep.around(geometry);
    if (!hull) {
      throw ModelError(path + ": link " + in_quotes(name) +
                       " follows a joint of the chain farther than 100 m; check the multipliers of its mimic joints");
    }
    const double before = volume(geometry.shape);
    geometry.shape = world::Convex{std::make_shared<world::ConvexHull>(std::move(*hull))};
    geometry.X_LS = Pose::Identity();
    geometry.excess_volume = volume(geometry.shape) / before - 1.0;
    geometry.capsule = link_capsule(geometry.shape);
    std::erase_if(model.self_pairs, [&](const std::pair<int, int>& pair) {
      if (pair.first != g && pair.second != g) return false;
      const int moved = moved_link(model, model.geometry[pair.first == g ? pair.second : pair.first].link);
      return moved >= 0 && sweep.joints().contains(model.links[moved].joint);
    });
    names.insert(name);
  }
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + in_quotes(name);
  if (!list.empty()) {
    model.notes.push_back(std::string("links beside the chain follow its joints") +
                          (ranges.empty() ? "" : " or move within their ranges") +
                          "; their shapes enclose all places where they may be: " + list);
  }
}

}  // namespace hecaton::planner
