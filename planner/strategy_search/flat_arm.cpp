#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "planner/strategy_search/motion_problem.hpp"

namespace hecaton::planner {
namespace {

/// A link's flat joint, and its pose in that joint's frame.
struct LinkPlace {
  int joint = -1;
  Pose X_FL = Pose::Identity();
};

struct Segment {
  Eigen::Vector3d p;
  Eigen::Vector3d q;
  double radius;
};

/// A capsule that encloses the shape, in the shape's frame [m].
Segment enclosing_segment(const LinkGeometry& geometry) {
  if (const auto* sphere = std::get_if<world::Sphere>(&geometry.shape)) {
    return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), sphere->radius};
  }
  if (const auto* capsule = std::get_if<world::Capsule>(&geometry.shape)) {
    const Eigen::Vector3d end(0.0, 0.0, capsule->half_length);
    return {-end, end, capsule->radius};
  }
  std::optional<LinkCapsule> fitted = geometry.capsule;
  if (!fitted) fitted = link_capsule(geometry.shape);
  if (fitted) {
    const Eigen::Vector3d end(0.0, 0.0, fitted->placed.capsule.half_length);
    return {fitted->placed.X_FS * -end, fitted->placed.X_FS * end, fitted->placed.capsule.radius};
  }
  const world::BoundingSphere bound = world::bounding_sphere(geometry.shape);
  return {bound.centre, bound.centre, bound.radius};
}

void put(const Eigen::Vector3d& v, double* out) {
  for (int i = 0; i < 3; ++i) out[i] = std::abs(v[i]) < 1e-12 ? 0.0 : v[i];
}

void put_axes(const Eigen::Matrix3d& R, double* out) {
  for (int c = 0; c < 3; ++c) put(R.col(c), out + 3 * c);
}

/// `X_FJ`: the joint's frame in that of the previous flat joint. `R_axis`: rotation of z to the joint's axis.
FlatJoint flat_joint(const Pose& X_FJ, const Eigen::Matrix3d& R_axis, JointType type) {
  FlatJoint joint;
  const Eigen::Matrix3d R = X_FJ.linear() * R_axis;
  put_axes(R, joint.R);
  put(X_FJ.translation(), joint.p);
  joint.rotated = !R.isIdentity(1e-12);
  joint.prismatic = type == JointType::kPrismatic;
  return joint;
}

std::vector<LinkPlace> place_links(const Arm& arm, int avoiding, const JointVector& q_rest, FlatArm& flat) {
  std::vector<LinkPlace> places;
  for (const Link& link : arm.model->links) {
    LinkPlace at = link.parent < 0 ? LinkPlace{-1, arm.X_WB} : places[link.parent];
    if (link.parent >= 0) at.X_FL = at.X_FL * link.X_PJ;
    if (link.joint >= 0 && link.joint < avoiding) {
      const Eigen::Matrix3d R_axis =
          Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), link.axis).toRotationMatrix();
      FlatJoint& joint = flat.joint[link.joint];
      joint = flat_joint(at.X_FL, R_axis, link.joint_type);
      // A continuous joint is limited to ± one turn.
      joint.lower = std::max(arm.limits.lower[link.joint], -2.0 * M_PI);
      joint.upper = std::min(arm.limits.upper[link.joint], 2.0 * M_PI);
      at.joint = link.joint;
      at.X_FL = Pose::Identity();
      at.X_FL.linear() = R_axis.transpose();
    } else if (link.joint >= 0 && link.joint_type == JointType::kPrismatic) {
      at.X_FL.translation() += at.X_FL.linear() * (link.axis * q_rest[link.joint]);
    } else if (link.joint >= 0) {
      at.X_FL.linear() = at.X_FL.linear() * Eigen::AngleAxisd(q_rest[link.joint], link.axis).toRotationMatrix();
    }
    places.push_back(at);
  }
  return places;
}

/// One body: collinear capsules of the model on one joint.
struct Part {
  int joint;
  Eigen::Vector3d p;  ///< end in the joint's frame [m]
  Eigen::Vector3d q;
  double radius;
  std::vector<int> geometry;  ///< indices of the model's geometry
};

constexpr double kTolerance = 1e-9;  // [m]

/// Moves a segment on the axis of a revolute joint to the joint before: it does not move with this one.
void move_to_last_mover(const FlatArm& arm, Part& part) {
  while (part.joint >= 0 && !arm.joint[part.joint].prismatic && part.p.head<2>().norm() < kTolerance &&
         part.q.head<2>().norm() < kTolerance) {
    const FlatJoint& joint = arm.joint[part.joint];
    const Eigen::Map<const Eigen::Matrix3d> R(joint.R);
    const Eigen::Map<const Eigen::Vector3d> origin(joint.p);
    part.p = origin + R * part.p;
    part.q = origin + R * part.q;
    --part.joint;
  }
}

/// Merges `added` into `part` if the two are collinear capsules that touch.
bool merge(Part& part, const Part& added) {
  if (part.joint != added.joint || std::abs(part.radius - added.radius) > kTolerance) return false;
  Eigen::Vector3d segment = part.q - part.p;
  if (segment.norm() < kTolerance) segment = added.q - added.p;
  if (segment.norm() < kTolerance) return false;
  const Eigen::Vector3d axis = segment.normalized();
  const auto along = [&](const Eigen::Vector3d& x) { return axis.dot(x - part.p); };
  const auto off = [&](const Eigen::Vector3d& x) { return (x - part.p - along(x) * axis).norm(); };
  if (std::max({off(part.q), off(added.p), off(added.q)}) > kTolerance) return false;
  const auto [low, high] = std::minmax({0.0, along(part.q)});
  const auto [from, to] = std::minmax({along(added.p), along(added.q)});
  if (from > high + kTolerance || to < low - kTolerance) return false;
  const Eigen::Vector3d origin = part.p;
  part.p = origin + std::min(low, from) * axis;
  part.q = origin + std::max(high, to) * axis;
  part.geometry.insert(part.geometry.end(), added.geometry.begin(), added.geometry.end());
  return true;
}

FlatBody flat_body(const Part& part) {
  FlatBody body;
  body.joint = part.joint;
  put(part.p, body.p);
  put(part.q - part.p, body.d);
  body.radius = part.radius;
  const double length2 = (part.q - part.p).squaredNorm();
  body.inverse2 = length2 > 1e-16 ? 1.0 / length2 : 0.0;
  body.reach = 0.5 * std::sqrt(length2) + part.radius;
  return body;
}

void refuse(const Arm& arm, const char* what, std::size_t have, int most) {
  if (static_cast<int>(have) <= most) return;
  throw ProblemError("arm " + arm.name + " has " + std::to_string(have) + " " + what +
                     "; the strategy search supports " + std::to_string(most));
}

/// `place`: index of the body of each geometry.
void add_pairs(const Arm& arm, const std::vector<int>& place, FlatArm& flat) {
  std::set<std::pair<int, int>> pairs;
  for (const auto& [a, b] : arm.model->self_pairs) {
    if (flat.body[place[a]].joint == flat.body[place[b]].joint) continue;
    pairs.emplace(std::min(place[a], place[b]), std::max(place[a], place[b]));
  }
  refuse(arm, "pairs of links that can touch", pairs.size(), kFlatPairs);
  for (const auto& [first, second] : pairs) flat.pair[flat.pairs++] = {first, second};
}

/// Upper bound of the distance of the body's ends from the axis of joint `from` [m].
double lever_of(const FlatArm& arm, int from, const FlatBody& body) {
  double sum = 0.0;
  bool first = true;
  const auto add = [&](const Eigen::Vector3d& v) {
    sum += first ? std::hypot(v.x(), v.y()) : v.norm();
    first = false;
  };
  for (int j = from + 1; j <= body.joint; ++j) {
    const FlatJoint& joint = arm.joint[j];
    add(Eigen::Vector3d(joint.p));
    if (joint.prismatic) sum += std::max(std::abs(joint.lower), std::abs(joint.upper));
  }
  const Eigen::Vector3d p(body.p);
  const Eigen::Vector3d q = p + Eigen::Vector3d(body.d);
  const auto length = [&](const Eigen::Vector3d& v) { return first ? std::hypot(v.x(), v.y()) : v.norm(); };
  return sum + std::max(length(p), length(q));
}

}  // namespace

FlatArm flatten(const Arm& arm, int avoiding, const JointVector& q_rest) {
  const RobotModel& model = *arm.model;
  FlatArm flat;
  flat.joints = avoiding;
  const std::vector<LinkPlace> places = place_links(arm, avoiding, q_rest, flat);
  std::vector<Part> parts;
  for (std::size_t i = 0; i < model.geometry.size(); ++i) {
    const LinkGeometry& geometry = model.geometry[i];
    const LinkPlace& link = places[geometry.link];
    const Pose X_FS = link.X_FL * geometry.X_LS;
    const Segment segment = enclosing_segment(geometry);
    Part part{link.joint, X_FS * segment.p, X_FS * segment.q, segment.radius, {static_cast<int>(i)}};
    move_to_last_mover(flat, part);
    if (std::none_of(parts.begin(), parts.end(), [&](Part& other) { return merge(other, part); })) {
      parts.push_back(std::move(part));
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.joint < b.joint; });
  refuse(arm, "bodies", parts.size(), kFlatBodies);
  std::vector<int> place(model.geometry.size());
  for (const Part& part : parts) {
    for (const int geometry : part.geometry) place[geometry] = flat.bodies;
    if (part.joint < 0) ++flat.fixed;
    flat.body[flat.bodies++] = flat_body(part);
  }
  add_pairs(arm, place, flat);
  for (int j = 0; j < avoiding; ++j) {
    for (int i = flat.fixed; i < flat.bodies; ++i) {
      if (flat.body[i].joint < j) continue;
      const double lever = flat.joint[j].prismatic ? 1.0 : lever_of(flat, j, flat.body[i]);
      flat.joint[j].lever = std::max(flat.joint[j].lever, lever);
    }
  }
  return flat;
}

double reach_from_first_joint(const FlatArm& arm, const FlatBody& body) {
  double sum = 0.0;
  for (int j = 0; j <= body.joint; ++j) {
    const FlatJoint& joint = arm.joint[j];
    if (j > 0) sum += Eigen::Vector3d(joint.p).norm();
    if (joint.prismatic) sum += std::max(std::abs(joint.lower), std::abs(joint.upper));
  }
  const Eigen::Vector3d p(body.p);
  return sum + std::max(p.norm(), (p + Eigen::Vector3d(body.d)).norm());
}

double reach_of(const FlatArm& arm) {
  return arm.joints > 0 ? arm.joint[0].lever : 0.0;
}

}  // namespace hecaton::planner
