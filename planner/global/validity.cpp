#include "planner/global/validity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/parameters.hpp"
#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner::global {
namespace {

/// Rounding error of a coordinate, as a share of the scale: ten times the largest error observed. Floats have 24 bits;
/// a coordinate is a sum of some dozens of products, and angles are rounded as well.
constexpr double kBodyRounding = 1e-5;

template <std::size_t N, typename Matrix>
std::array<float, N> floats(const Matrix& values) {
  std::array<float, N> result;
  for (std::size_t i = 0; i < N; ++i) result[i] = static_cast<float>(values.data()[i]);
  return result;
}

double largest_angle(const JointLimits& limits) {
  double largest = 0.0;
  for (Eigen::Index j = 0; j < limits.lower.size(); ++j) {
    const double bound = std::max(std::abs(limits.lower[j]), std::abs(limits.upper[j]));
    largest = std::max(largest, std::isfinite(bound) ? bound : 10.0);
  }
  return largest;
}

KernelSphere kernel_sphere(const Pose& X_FS, const world::BoundingSphere& sphere, double inner, double rounding) {
  const Eigen::Vector3d centre = X_FS * sphere.centre;
  return {floats<3>(centre), static_cast<float>(sphere.radius + rounding),
          static_cast<float>(std::max(0.0, inner - 2.0 * rounding))};
}

/// Radius of the largest sphere about p that lies within the shape [m]; 0 if p lies outside. It equals the depth of p
/// in the convex shape.
double inner_radius(const SweptCore& core, const Eigen::Vector3d& p) {
  static const SweptCore point = make_swept_core(world::Sphere{0.0});
  const Pose at(Eigen::Translation3d{p});
  return std::max(0.0, -prepared_distance(point, at, core, Pose::Identity()).distance);
}

Pose pose_of(const float* frame) {
  Pose X_OF = Pose::Identity();
  for (int k = 0; k < 12; ++k) X_OF.matrix()(k % 3, k / 3) = static_cast<double>(frame[k]);
  return X_OF;
}

world::BoundingSphere tight_bound(const world::Shape& shape) {
  const auto* convex = std::get_if<world::Convex>(&shape);
  world::BoundingSphere rough = world::bounding_sphere(shape);
  if (convex == nullptr) return rough;
  const world::BoundingSphere sphere = bounding_sphere_of(convex->hull->vertices);
  return sphere.radius < rough.radius ? sphere : rough;
}

/// A link's kernel frame, and its pose in that frame.
struct LinkPlace {
  int frame = -1;
  Pose X_FL = Pose::Identity();
};

}  // namespace

const ValidityKernel& fastest_validity() {
  return *fastest(&baseline::kValidity, &avx2::kValidity);
}

std::vector<WorldBody> world_bodies(const CellGeometry& geometry, std::span<const Pose> X_WO,
                                    std::span<const JointVector> others) {
  std::vector<WorldBody> bodies;
  for (int i = 0; i < geometry.obstacle_count(); ++i) {
    for (const Body& body : geometry.obstacle_bodies(i)) {
      bodies.push_back({body.shape, X_WO[i] * body.X_CS, geometry.obstacle_name(i)});
    }
  }
  for (int arm = 0; arm < static_cast<int>(geometry.arms().size()); ++arm) {
    if (arm == geometry.self() || others[arm].size() == 0) continue;
    const Arm& other = geometry.arms()[arm];
    Kinematics kinematics;
    forward_kinematics(*other.model, other.X_WB, others[arm], kinematics);
    for (const Body& body : geometry.arm_bodies(arm)) {
      bodies.push_back({body.shape, kinematics.X_WL[body.link] * body.X_CS, geometry.body_name(arm, body)});
    }
  }
  return bodies;
}

Validity::Validity(std::vector<CellGeometry> planned, std::span<const WorldBody> world, const ValidityOptions& options)
    : planned_(std::move(planned)), options_(options) {
  X_OW_ = planned_.front().own_arm().X_WB.inverse();
  scale_ = 0.0;
  for (const CellGeometry& geometry : planned_) {
    const world::BoundingSphere& reach = geometry.arm_reach(geometry.self());
    const double farthest = (X_OW_ * reach.centre).norm() + reach.radius;
    scale_ = std::max(scale_, farthest * (1.0 + 0.1 * largest_angle(geometry.own_arm().limits)));
    robot_.dimensions += geometry.own_arm().model->joints();
  }
  if (robot_.dimensions > kMaxDimensions) {
    throw std::invalid_argument("arms of " + std::to_string(robot_.dimensions) +
                                " joints in total cannot be planned together (at most " +
                                std::to_string(kMaxDimensions) + ")");
  }
  std::vector<int> first_body;
  for (const CellGeometry& geometry : planned_) {
    first_body.push_back(static_cast<int>(robot_.bodies.size()));
    add_arm(geometry, static_cast<int>(robot_.frames.size()), first_body.back());
  }
  if (robot_.bodies.size() > kMaxBodies || robot_.spheres.size() > kMaxSpheres) {
    throw std::invalid_argument("arms of " + std::to_string(robot_.bodies.size()) + " bodies and " +
                                std::to_string(robot_.spheres.size()) +
                                " covering spheres cannot be planned together (at most " + std::to_string(kMaxBodies) +
                                " and " + std::to_string(kMaxSpheres) + ")");
  }
  add_pairs(first_body);
  levers_ = body_levers(planned_);
  for (int i = static_cast<int>(robot_.bodies.size()) - 1; i >= 0; --i) {
    if (robot_.bodies[i].frame >= 0) robot_.order.push_back(i);
  }
  set_world(world);
}

void Validity::add_arm(const CellGeometry& geometry, int first_dimension, int first_body) {
  const Arm& arm = geometry.own_arm();
  const double rounding = kBodyRounding * scale_;
  std::vector<LinkPlace> places(arm.model->links.size());
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Link& link = arm.model->links[i];
    const LinkPlace root{-1, X_OW_ * arm.X_WB};
    const LinkPlace& parent = link.parent < 0 ? root : places[link.parent];
    const Pose X_FJ = parent.X_FL * link.X_PJ;
    if (link.joint < 0) {
      places[i] = {parent.frame, X_FJ};
      continue;
    }
    // Z: rotated such that its z axis is the joint's axis.
    const Pose X_JZ(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), link.axis));
    const Pose X_FZ = X_FJ * X_JZ;
    KernelFrame frame;
    frame.parent = parent.frame;
    frame.prismatic = link.joint_type == JointType::kPrismatic;
    const Eigen::Matrix3d rotation = X_FZ.linear();
    const Eigen::Vector3d translation = X_FZ.translation();
    frame.rotation = floats<9>(rotation);
    frame.translation = floats<3>(translation);
    places[i] = {first_dimension + link.joint, X_JZ.inverse()};
    if (static_cast<int>(robot_.frames.size()) != places[i].frame) {
      throw std::invalid_argument("arm " + arm.name + ": the joints are not numbered in the order of the links");
    }
    robot_.frames.push_back(frame);
  }
  for (const Body& body : geometry.own_bodies()) {
    const LinkPlace& place = places[body.link];
    const Pose X_FS = place.X_FL * body.X_CS;
    KernelBody& kernel_body = robot_.bodies.emplace_back();
    kernel_body.frame = place.frame;
    const SweptCore& core = body_cores_.emplace_back(PlacedCore{make_swept_core(body.shape), X_FS}).core;
    const auto sphere_of = [&](const world::BoundingSphere& sphere) {
      return kernel_sphere(X_FS, sphere, inner_radius(core, sphere.centre), rounding);
    };
    kernel_body.bound = sphere_of(tight_bound(body.shape));
    kernel_body.first = static_cast<int>(robot_.spheres.size());
    for (const world::BoundingSphere& sphere : sphere_cover(body.shape, options_.cover)) {
      robot_.spheres.push_back(sphere_of(sphere));
    }
    kernel_body.count = static_cast<int>(robot_.spheres.size()) - kernel_body.first;
  }
  body_arm_.resize(robot_.bodies.size(), body_arm_.empty() ? 0 : body_arm_.back() + 1);
  for (const auto& [a, b] : geometry.self_pairs()) {
    const double padding = std::min(options_.self_padding, kSecurityShare * geometry.widest(a, b));
    if (padding < options_.self_padding) close_pairs_.push_back({first_body + a, first_body + b, padding});
    robot_.pairs.push_back({first_body + a, first_body + b, static_cast<float>(padding)});
  }
}

void Validity::add_pairs(const std::vector<int>& first_body) {
  const auto padding = static_cast<float>(options_.padding);
  const auto end_of = [&](std::size_t arm) {
    return arm + 1 < first_body.size() ? first_body[arm + 1] : static_cast<int>(robot_.bodies.size());
  };
  for (std::size_t one = 0; one < first_body.size(); ++one) {
    for (std::size_t two = one + 1; two < first_body.size(); ++two) {
      for (int a = first_body[one]; a < end_of(one); ++a) {
        for (int b = first_body[two]; b < end_of(two); ++b) {
          const bool fixed = robot_.bodies[a].frame < 0 || robot_.bodies[b].frame < 0;
          if (fixed && same_robot(planned_[one].own_arm(), planned_[two].own_arm())) continue;
          robot_.pairs.push_back({a, b, padding});
        }
      }
    }
  }
  std::erase_if(robot_.pairs, [&](const KernelPair& pair) {
    return robot_.bodies[pair.a].frame < 0 && robot_.bodies[pair.b].frame < 0;
  });
}

void Validity::set_world(std::span<const WorldBody> world) {
  world_bodies_.assign(world.begin(), world.end());
  world_ = kernel_world(world_bodies_, X_OW_);
  world_.padding = static_cast<float>(options_.padding);
  world_cores_.clear();
  for (const WorldBody& body : world_bodies_) world_cores_.push_back({make_swept_core(body.shape), X_OW_ * body.X_WS});
}

double Validity::from_obstacle(const void* self, int body, const float* frame, int obstacle) {
  const auto& validity = *static_cast<const Validity*>(self);
  const PlacedCore& own = validity.body_cores_[body];
  const PlacedCore& other = validity.world_cores_[obstacle];
  return prepared_distance(own.core, pose_of(frame) * own.X_FS, other.core, other.X_FS).distance -
         kBodyRounding * validity.scale_;
}

double Validity::from_body(const void* self, int a, const float* frame_a, int b, const float* frame_b) {
  const auto& validity = *static_cast<const Validity*>(self);
  const PlacedCore& one = validity.body_cores_[a];
  const PlacedCore& two = validity.body_cores_[b];
  const ValidityOptions& options = validity.options_;
  double padding = validity.body_arm_[a] == validity.body_arm_[b] ? options.self_padding : options.padding;
  for (const PaddedPair& pair : validity.close_pairs_) {
    if (pair.a == a && pair.b == b) padding = pair.padding;
  }
  return prepared_distance(one.core, pose_of(frame_a) * one.X_FS, two.core, pose_of(frame_b) * two.X_FS).distance -
         padding - 2.0 * kBodyRounding * validity.scale_;
}

bool Validity::state_free(const float* q) const {
  ++checks_;
  return fastest_validity().collisions(robot_, world_, exact(), q, 0) == 0;
}

unsigned Validity::collisions(const float* eight) const {
  checks_ += kWidth;
  return fastest_validity().collisions(robot_, world_, exact(), eight, stride());
}

bool Validity::edge_free(const float* a, const float* b, int finer) const {
  double length2 = 0.0;
  for (int j = 0; j < robot_.dimensions; ++j) length2 += std::pow(b[j] - a[j], 2);
  const int blocks = std::max(1, static_cast<int>(std::ceil(std::sqrt(length2) * finer / (options_.step * kWidth))));
  checks_ += static_cast<std::uint64_t>(blocks) * kWidth;
  return fastest_validity().edge_free(robot_, world_, exact(), a, b, blocks);
}

Validity::Nearest Validity::nearest(std::span<const double> q) const {
  return smallest(q, false);
}

Validity::Nearest Validity::tightest(std::span<const double> q) const {
  return smallest(q, true);
}

Validity::Nearest Validity::smallest(std::span<const double> q, bool as_margin) const {
  struct Placed {
    const Body* body;
    Pose X_WS;
    std::string name;
  };
  std::vector<Placed> bodies;
  Eigen::Index first = 0;
  for (const CellGeometry& geometry : planned_) {
    const Arm& arm = geometry.own_arm();
    const Eigen::Index joints = arm.model->joints();
    const JointVector own = Eigen::Map<const Eigen::VectorXd>(q.data() + first, joints);
    first += joints;
    Kinematics kinematics;
    forward_kinematics(*arm.model, arm.X_WB, own, kinematics);
    for (const Body& body : geometry.own_bodies()) {
      bodies.push_back({&body, kinematics.X_WL[body.link] * body.X_CS, geometry.body_name(geometry.self(), body)});
    }
  }
  Nearest nearest{{}, {}, std::numeric_limits<double>::infinity(), 0.0};
  const auto margin = [&](const Nearest& pair) { return pair.distance - (as_margin ? pair.required : 0.0); };
  const auto consider = [&](const Placed& a, const world::Shape& shape, const Pose& X_WS, const std::string& name,
                            double required) {
    const Nearest pair{a.name, name, shape_distance(a.body->shape, a.X_WS, shape, X_WS).distance, required};
    if (margin(pair) < margin(nearest)) nearest = pair;
  };
  for (const KernelPair& pair : robot_.pairs) {
    const Placed& b = bodies[pair.b];
    consider(bodies[pair.a], b.body->shape, b.X_WS, b.name, pair.padding);
  }
  for (const Placed& own : bodies) {
    if (!own.body->moves) continue;
    for (const WorldBody& other : world_bodies_) {
      consider(own, other.shape, other.X_WS, other.name, options_.padding);
    }
  }
  return nearest;
}

}  // namespace hecaton::planner::global
