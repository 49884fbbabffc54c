#include "planner/global/validity.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "planner/collision/cloud_distance.hpp"
#include "planner/collision/exact_distance.hpp"

namespace hecaton::planner::global {
namespace {

Pose pose_of(const float* frame) {
  Pose X_OF = Pose::Identity();
  for (int k = 0; k < 12; ++k) X_OF.matrix()(k % 3, k / 3) = static_cast<double>(frame[k]);
  return X_OF;
}

/// The largest n · p of a placed shape's points p [m].
double farthest_along(const SweptCore& core, const Pose& X, const Eigen::Vector3d& n) {
  return n.dot(X * farthest(core, X.linear().transpose() * n)) + core.radius;
}

/// A shape on its way.
struct MovedCore {
  const SweptCore& core;
  const Pose& from;
  const Pose& to;
};

/// Distance of two shapes along the axis n from a to b [m]; negative: they overlap along it.
double gap_along(const MovedCore& a, const MovedCore& b, const Eigen::Vector3d& n, bool at_end) {
  return -farthest_along(a.core, at_end ? a.to : a.from, n) - farthest_along(b.core, at_end ? b.to : b.from, -n);
}

/// An axis along which the shapes are apart at both ends of their ways parts them all the way, if their points move
/// straight.
ExactGap gap_on_way(const MovedCore& a, const MovedCore& b, double rounding, ExactQuestion& question) {
  Eigen::Map<Eigen::Vector3d> axis(question.axis.data());
  const bool on_way = question.to_a != nullptr;
  if (on_way && axis.squaredNorm() > 0.0) {
    const double known = std::min(gap_along(a, b, axis, false), gap_along(a, b, axis, true)) - rounding;
    if (known > question.enough) return {known, known};
  }
  const ShapeDistance gap = prepared_distance(a.core, a.from, b.core, b.from);
  axis = gap.n_W;
  const double at_start = gap.distance - rounding;
  if (!on_way || gap.distance <= 0.0) return {at_start, at_start};
  return {at_start, std::min(at_start, gap_along(a, b, gap.n_W, true) - rounding)};
}

/// The same from the balls of a cloud at X_OP. On the way each ball within reach is looked at by itself.
ExactGap gap_from_cloud(const MovedCore& a, const world::PointCloud& cloud, const Pose& X_OP, double rounding,
                        const ExactQuestion& question) {
  const double infinite = std::numeric_limits<double>::infinity();
  const double at_start = cloud_distance({a.core, a.from}, cloud, X_OP, infinite).distance - rounding;
  if (question.to_a == nullptr || at_start <= question.enough) return {at_start, at_start};

  // In the frame of the cloud: a box around the core at both ends contains its straight way.
  const Pose X_PO = X_OP.inverse(Eigen::Isometry);
  world::PointBox box{};
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d n = X_PO.linear().row(axis).transpose();
    const double offset = X_PO.translation()[axis];
    const auto side = [&](double sign) {
      const auto end = [&](const Pose& X) { return farthest_along(a.core, X, sign * n) - a.core.radius; };
      return sign * std::max(end(a.from), end(a.to)) + offset;
    };
    box.low[axis] = std::nextafter(static_cast<float>(side(-1.0)), -HUGE_VALF);
    box.high[axis] = std::nextafter(static_cast<float>(side(1.0)), HUGE_VALF);
  }
  const SweptCore ball{Core::kPoint, cloud.radius(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), {}};
  double on_way = at_start;
  ExactQuestion of_ball = question;
  const auto look = [&](const Eigen::Vector3f& centre) {
    const Pose X_OB(Eigen::Translation3d(X_OP * centre.cast<double>()));
    of_ball.axis = {};
    on_way = std::min(on_way, gap_on_way(a, {ball, X_OB, X_OB}, rounding, of_ball).on_way);
    return on_way > question.enough;  // less proves nothing
  };
  // A ball beyond this reach is far enough, wherever the shape is.
  for_centres_near(cloud, box, question.enough + rounding + cloud.radius() + a.core.radius, look);
  return {at_start, std::min(on_way, at_start)};
}

}  // namespace

std::span<const ValidityKernel* const> supported_kernels() {
  static constexpr const ValidityKernel* kAll[] = {&lanes4::kValidity, &lanes8::kValidity, &lanes16::kValidity};
  static const std::size_t count = [] {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2") == 0 || __builtin_cpu_supports("fma") == 0) return 1;
    const bool wide = __builtin_cpu_supports("avx512f") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
                      __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512vl") != 0;
    return wide ? 3 : 2;
#else
    return 1;
#endif
  }();
  return {kAll, count};
}

const ValidityKernel& fastest_validity() {
  static const ValidityKernel& chosen = *supported_kernels().back();
  return chosen;
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
  built_ = kernel_robot(planned_, X_OW_, options_.cover, {options_.padding, options_.self_padding});
  levers_ = body_levers(planned_);
  set_world(world);
}

void Validity::set_world(std::span<const WorldBody> world) {
  world_bodies_.assign(world.begin(), world.end());
  world_ = kernel_world(world_bodies_, X_OW_, options_.padding, built_.reach_of_link);
  world_cores_.clear();
  for (const WorldBody& body : world_bodies_) {
    const bool points = std::holds_alternative<world::Points>(body.shape);
    world_cores_.push_back({points ? SweptCore{} : make_swept_core(body.shape), X_OW_ * body.X_WS});
  }
  memory_.hit_link = -1;
}

ExactGap Validity::from_obstacle(const void* self, int body, int obstacle, ExactQuestion& question) {
  const auto& validity = *static_cast<const Validity*>(self);
  const PlacedCore& own = validity.built_.cores[body];
  const PlacedCore& other = validity.world_cores_[obstacle];
  const Pose from = pose_of(question.from_a) * own.X_FS;
  const Pose to = question.to_a == nullptr ? from : pose_of(question.to_a) * own.X_FS;
  if (const auto* points = std::get_if<world::Points>(&validity.world_bodies_[obstacle].shape)) {
    return gap_from_cloud({own.core, from, to}, *points->cloud, other.X_FS, validity.built_.rounding_of_body[body],
                          question);
  }
  return gap_on_way({own.core, from, to}, {other.core, other.X_FS, other.X_FS}, validity.built_.rounding_of_body[body],
                    question);
}

ExactGap Validity::from_body(const void* self, int a, int b, ExactQuestion& question) {
  const auto& validity = *static_cast<const Validity*>(self);
  const PlacedCore& one = validity.built_.cores[a];
  const PlacedCore& two = validity.built_.cores[b];
  const double rounding = validity.built_.rounding_of_body[a] + validity.built_.rounding_of_body[b];
  Pose from_a = pose_of(question.from_a);
  Pose from_b = pose_of(question.from_b);
  Pose to_a = question.to_a == nullptr ? from_a : pose_of(question.to_a);
  Pose to_b = question.to_b == nullptr ? from_b : pose_of(question.to_b);
  if (question.seen_from_a) {
    from_b = from_a.inverse(Eigen::Isometry) * from_b;
    to_b = to_a.inverse(Eigen::Isometry) * to_b;
    from_a = to_a = Pose::Identity();
  }
  return gap_on_way({one.core, from_a * one.X_FS, to_a * one.X_FS}, {two.core, from_b * two.X_FS, to_b * two.X_FS},
                    rounding, question);
}

KernelScene Validity::scene(const ValidityKernel& kernel) const {
  const std::size_t needed = kernel.floats_needed(built_.robot);
  if (memory_.storage.size() < needed) memory_.storage.resize(needed);
  return {built_.robot, world_, {this, from_obstacle, from_body}, memory_};
}

bool Validity::state_free(const float* q) const {
  ++checks_;
  const KernelScene at = scene(fastest_validity());
  return fastest_validity().collisions(at, q, 0) == 0;
}

unsigned Validity::collisions(const float* q) const {
  return collisions(fastest_validity(), q);
}

unsigned Validity::collisions(const ValidityKernel& kernel, const float* q) const {
  checks_ += kWidth;
  return kernel.collisions(scene(kernel), q, stride());
}

void Validity::count_checks(const float* a, const float* b) const {
  float length2 = 0.0F;
  for (int j = 0; j < dimensions(); ++j) length2 += (b[j] - a[j]) * (b[j] - a[j]);
  checks_ +=
      static_cast<std::uint64_t>(std::max(1.0, std::ceil(std::sqrt(static_cast<double>(length2)) / options_.step)));
}

bool Validity::edge_free(const float* a, const float* b, const EdgeCheck& check) const {
  return edge_free(fastest_validity(), a, b, check);
}

bool Validity::edge_free(const ValidityKernel& kernel, const float* a, const float* b, const EdgeCheck& check) const {
  const std::uint64_t before = checks_;
  count_checks(a, b);
  const KernelEdge edge{a, nullptr, b, nullptr, static_cast<float>(check.clearance)};
  if (check.proven) return kernel.edge_proven(scene(kernel), edge);
  return kernel.edge_sampled(scene(kernel), edge, static_cast<int>(checks_ - before));
}

bool Validity::curve_free(const float* a, const float* corner, const float* b, double clearance,
                          const float* spread) const {
  count_checks(a, corner);
  count_checks(corner, b);
  const KernelEdge edge{a, corner, b, spread, static_cast<float>(clearance)};
  return fastest_validity().edge_proven(scene(fastest_validity()), edge);
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
  for (const KernelPair& pair : built_.robot.pairs) {
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
