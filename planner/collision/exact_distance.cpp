#include "planner/collision/exact_distance.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "planner/collision/cloud_distance.hpp"
#include "planner/collision/convex_distance.hpp"
#include "planner/collision/pass_kernels.hpp"
#include "planner/collision/primitive_distance.hpp"
#include "planner/collision/swept_core.hpp"
#include "planner/model/capsules.hpp"
#include "planner/simd/instruction_set.hpp"

namespace hecaton::planner {
namespace {

Segment segment(const SweptCore& core, const Pose& X_WS) {
  const Eigen::Vector3d half = core.half.z() * X_WS.linear().col(2);
  return {X_WS.translation() - half, X_WS.translation() + half};
}

/// A segment this near to a cylinder [m] is left to the general method, which also measures overlap.
constexpr double kClearlyApart = 1e-6;

ShapeDistance core_distance(const SweptCore& a, const Pose& X_WA, const SweptCore& b, const Pose& X_WB) {
  const bool a_is_thin = a.core <= Core::kSegment;
  const bool b_is_thin = b.core <= Core::kSegment;
  if (a_is_thin && b_is_thin) return segment_segment(segment(a, X_WA), segment(b, X_WB));
  if (b_is_thin) return exchanged(core_distance(b, X_WB, a, X_WA));
  if (a_is_thin && b.core == Core::kBox) return segment_box(segment(a, X_WA), b.half, X_WB);
  if (a.core == Core::kPoint && b.core == Core::kCylinder) {
    return point_cylinder(X_WA.translation(), b.half.x(), b.half.z(), X_WB);
  }
  if (a_is_thin && b.core == Core::kCylinder) {
    if (const auto apart = segment_cylinder_apart(segment(a, X_WA), b.half.x(), b.half.z(), X_WB, kClearlyApart)) {
      return *apart;
    }
  }
  return convex_distance(a, X_WA, b, X_WB);
}

ShapeDistance distance(const SweptCore& a, const Pose& X_WA, const SweptCore& b, const Pose& X_WB) {
  return swept(core_distance(a, X_WA, b, X_WB), a.radius, b.radius);
}

/// Drops the farthest clearance of a full list if it is farther than `distance`; keeps the order.
bool drop_farthest(std::span<Clearance> full, double distance) {
  const auto farthest = std::max_element(
      full.begin(), full.end(), [](const Clearance& a, const Clearance& b) { return a.distance < b.distance; });
  if (farthest == full.end() || distance >= farthest->distance) return false;
  std::move(farthest + 1, full.end(), farthest);
  return true;
}

/// The core of a shape or of the capsule that replaces it.
struct PlacedCore {
  SweptCore core;
  Pose X_CS = Pose::Identity();  ///< in its carrier (link or obstacle) C
};

/// A body of the pass and its owner.
struct PassBody {
  Counterpart counterpart = Counterpart::kObstacle;  ///< kSelf: a body of the own arm
  int owner = 0;                                     ///< arm or obstacle index
  int index = 0;                                     ///< among the owner's bodies
  int link = -1;                                     ///< −1: obstacle
  PlacedCore placed;                                 ///< for distances from bodies of other owners
  PlacedCore own_shape;                              ///< for distances between bodies of the own arm
  std::shared_ptr<const world::PointCloud> cloud{};  ///< instead of a core
};

Quad quad(const Eigen::Vector3d& v, double w) {
  return {v.x(), v.y(), v.z(), w};
}

bool is_thin(const world::Shape& shape) {
  return std::holds_alternative<world::Sphere>(shape) || std::holds_alternative<world::Capsule>(shape);
}

/// In the carrier's frame.
PlacedCapsule capsule_around(const Body& body) {
  if (body.capsule) return *body.capsule;
  PlacedCapsule around = bounding_capsule(body.shape);
  around.X_FS = body.X_CS * around.X_FS;
  return around;
}

LaneBody lane_body(const Body& body, bool own) {
  LaneBody lane;
  lane.ball_C = quad(body.bound.centre, body.bound.radius);
  lane.kind = body.capsule || is_thin(body.shape) ? BodyKind::kThin : BodyKind::kOther;
  const PlacedCapsule around = capsule_around(body);
  lane.middle_C = quad(around.X_FS.translation(), around.capsule.radius);
  lane.axis_C = quad(around.X_FS.linear().col(2), around.capsule.half_length);
  if (const auto* box = std::get_if<world::Box>(&body.shape); box != nullptr && !own && !body.capsule) {
    lane.kind = BodyKind::kBox;
    for (int i = 0; i < 3; ++i) lane.box_C[i] = quad(body.X_CS.linear().col(i), box->half_extents[i]);
    lane.in_place = body.X_CS.matrix().isIdentity(0.0) && body.bound.centre.isZero(0.0);
  }
  return lane;
}

}  // namespace

struct ExactDistance::Storage {
  Storage(const CellGeometry& geometry, PassKernel pass_kernel)
      : self_pairs(geometry.self_pairs()), kernel(pass_kernel) {
    for (const auto& [first, second] : self_pairs) widest.push_back(geometry.widest(first, second));
    add(Counterpart::kSelf, geometry.self(), geometry.own_bodies());
    own_count = static_cast<int>(geometry.own_bodies().size());
    range_of_arm.resize(geometry.arms().size());
    for (int arm = 0; arm < static_cast<int>(geometry.arms().size()); ++arm) {
      if (arm == geometry.self()) continue;
      range_of_arm[arm].first = static_cast<int>(bodies.size());
      const bool shares_base = same_robot(geometry.arms()[arm], geometry.own_arm());
      add(Counterpart::kArm, arm, geometry.arm_bodies(arm), shares_base);
      range_of_arm[arm].end = static_cast<int>(bodies.size());
      other_arms.push_back(arm);
    }
    obstacles.first = static_cast<int>(bodies.size());
    for (int obstacle = 0; obstacle < geometry.obstacle_count(); ++obstacle) {
      first_of_obstacle.push_back(static_cast<int>(bodies.size()));
      add(Counterpart::kObstacle, obstacle, geometry.obstacle_bodies(obstacle));
    }
    obstacles.end = static_cast<int>(bodies.size());

    scratch.places.resize(bodies.size());
    scratch.balls.resize(4 * bodies.size());
    scratch.carrier.resize(bodies.size());
    scratch.reach_of_arm.resize(geometry.arms().size());
    scratch.reach_of_body.resize(obstacles.end - obstacles.first + 1);
    scratch.still.assign(own_count, 0.0);
    group_own_bodies(geometry.own_bodies());
    const std::size_t possible = self_pairs.size() + own_count * bodies.size();
    scratch.pairs.resize(possible);
    scratch.thin_pairs.resize(possible);
    scratch.box_pairs.resize(possible);
    scratch.ranges.reserve(geometry.arms().size() + 1);
  }

  /// `shares_base`: bodies of another arm of the own arm's robot, which may touch the bodies that no joint moves.
  void add(Counterpart counterpart, int owner, const std::vector<Body>& added, bool shares_base = false) {
    for (int i = 0; i < static_cast<int>(added.size()); ++i) {
      const Body& body = added[i];
      const auto* points = std::get_if<world::Points>(&body.shape);
      const PlacedCore own_shape{points != nullptr ? SweptCore{} : make_swept_core(body.shape), body.X_CS};
      const PlacedCore placed =
          body.capsule ? PlacedCore{make_swept_core(body.capsule->capsule), body.capsule->X_FS} : own_shape;
      bodies.push_back(
          {counterpart, owner, i, body.link, placed, own_shape, points != nullptr ? points->cloud : nullptr});
      capsules_bound_only.push_back(!is_thin(body.shape));
      lane_bodies.push_back(lane_body(body, counterpart == Counterpart::kSelf));
      carried_by.push_back(counterpart == Counterpart::kObstacle ? owner : body.link);
      radius.push_back(static_cast<float>(body.bound.radius) * (1.0F + kOutwards));
      pairs_with_fixed.push_back(counterpart == Counterpart::kArm && body.moves && !shares_base ? 1 : 0);
    }
  }

  /// Groups of eight. Padding in the last group is far away, but its squared distance is still a float.
  void group_own_bodies(const std::vector<Body>& own) {
    scratch.own_groups.resize((own.size() + OwnGroup::kBodies - 1) / OwnGroup::kBodies);
    for (OwnGroup& group : scratch.own_groups) std::fill(std::begin(group.ball_x), std::end(group.ball_x), 1e18F);
    for (std::size_t i = 0; i < own.size(); ++i) {
      OwnGroup& group = scratch.own_groups[i / OwnGroup::kBodies];
      const std::size_t lane = i % OwnGroup::kBodies;
      group.ball_radius[lane] = radius[i];
      group.capsule_radius[lane] = static_cast<float>(lane_bodies[i].middle_C.w) * (1.0F + kOutwards);
      group.bodies |= 1U << lane;
      if (own[i].moves) group.moving |= 1U << lane;
    }
  }

  void place(const CellPoses& poses, const InfluenceDistances& influence) {
    for (int i = 0; i < own_count; ++i) scratch.carrier[i] = poses.own->X_WL[carried_by[i]].data();
    scratch.ranges.clear();
    for (const int arm : influence.near_arms.value_or(std::span<const int>(other_arms))) {
      LaneRange range = range_of_arm[arm];
      for (int i = range.first; i < range.end; ++i) scratch.carrier[i] = poses.arms[arm].X_WL[carried_by[i]].data();
      scratch.reach_of_arm[arm] = influence.against_arm(arm);
      range.reach = &scratch.reach_of_arm[arm];
      scratch.ranges.push_back(range);
    }
    obstacles.reach_of_each = influence.of_obstacle.size() > 1;
    for (int i = obstacles.first; i < obstacles.end; ++i) {
      scratch.carrier[i] = poses.obstacles[carried_by[i]].X_WO.data();
      if (obstacles.reach_of_each) scratch.reach_of_body[i - obstacles.first] = influence.of_obstacle[carried_by[i]];
    }
    if (obstacles.first < obstacles.end && !obstacles.reach_of_each) {
      scratch.reach_of_body[0] = influence.against_obstacle(0);
    }
    obstacles.reach = scratch.reach_of_body.data();
    scratch.ranges.push_back(obstacles);
  }

  std::span<const LanePair> find(const CellPoses& poses, const InfluenceDistances& influence) {
    place(poses, influence);
    LanePass pass;
    pass.bodies = lane_bodies.data();
    pass.carrier = scratch.carrier.data();
    pass.places = scratch.places.data();
    pass.own_count = own_count;
    pass.own_speed = influence.own_speed.empty() ? scratch.still.data() : influence.own_speed.data();
    pass.own_groups = scratch.own_groups.data();
    pass.radius = radius.data();
    pass.ball = scratch.balls.data();
    pass.pairs_with_fixed = pairs_with_fixed.data();
    pass.ranges = scratch.ranges.data();
    pass.range_count = static_cast<int>(scratch.ranges.size());
    pass.thin_pairs = scratch.thin_pairs.data();
    pass.box_pairs = scratch.box_pairs.data();
    pass.pairs = scratch.pairs.data();
    for (std::size_t i = 0; i < self_pairs.size(); ++i) {
      const auto& [first, second] = self_pairs[i];
      LanePair& pair = scratch.pairs[pass.pair_count++];
      pair.own = first;
      pair.other = second;
      pair.limit = std::min(influence.against_self(first, second), influence.self_share * widest[i]);
      pair.cull = capsules_bound_only[first] || capsules_bound_only[second];
    }
    kernel(pass);
    return std::span(scratch.pairs).first(pass.pair_count);
  }

  /// Measures a pair that the kernel left open.
  [[nodiscard]] ShapeDistance measure(const LanePair& pair) const {
    const auto side = [&](int body) -> const PlacedCore& {
      return pair.other < own_count ? bodies[body].own_shape : bodies[body].placed;
    };
    const auto pose = [&](int body) {
      return Pose(Eigen::Map<const Eigen::Matrix4d>(scratch.carrier[body])) * side(body).X_CS;
    };
    return distance(side(pair.own).core, pose(pair.own), side(pair.other).core, pose(pair.other));
  }

  /// Measures an open pair with a cloud. Returns how many of `out` are nearer than its limit.
  [[nodiscard]] int measure_cloud(const LanePair& pair, std::span<ShapeDistance> out) const {
    const PlacedCore& own = bodies[pair.own].placed;
    const PassBody& other = bodies[pair.other];
    const auto pose = [&](int body, const Pose& X_CS) {
      return Pose(Pose(Eigen::Map<const Eigen::Matrix4d>(scratch.carrier[body])) * X_CS);
    };
    return nearest_balls({own.core, pose(pair.own, own.X_CS)}, *other.cloud, pose(pair.other, other.placed.X_CS),
                         pair.limit, out);
  }

  [[nodiscard]] ShapeDistance measure_sweep(const Clearance& obstacle, const CellPoses& poses,
                                            const Sweep& sweep) const {
    const PlacedCore& own = bodies[obstacle.own_body].placed;
    const PassBody& swept_body = bodies[first_of_obstacle[obstacle.other] + obstacle.other_body];
    if (swept_body.cloud) return {};  // any ball may come: no way past is proved
    const PlacedCore& other = swept_body.placed;
    const ShapeDistance cores =
        planner::sweep_distance(own.core, poses.own->X_WL[obstacle.own_link] * own.X_CS, other.core,
                                poses.obstacles[obstacle.other].X_WO * other.X_CS, sweep);
    return swept(cores, own.core.radius, other.core.radius);
  }

  std::vector<PassBody> bodies;
  std::vector<LaneBody> lane_bodies;
  std::vector<bool> capsules_bound_only;  ///< the capsule is not the shape, which counts between bodies of the own arm
  std::vector<int> carried_by;            ///< of each body: its link or obstacle
  std::vector<float> radius;              ///< of each bounding ball, rounded outwards [m]
  std::vector<std::uint8_t> pairs_with_fixed;
  int own_count = 0;
  std::vector<std::pair<int, int>> self_pairs;
  std::vector<double> widest;  ///< of each self pair [m]
  std::vector<int> other_arms;
  std::vector<LaneRange> range_of_arm;
  LaneRange obstacles;
  std::vector<int> first_of_obstacle;  ///< its first body
  PassKernel kernel;

  /// Storage that every pass overwrites, but for the radii in own_groups.
  struct Scratch {
    std::vector<LanePlace> places;
    std::vector<const double*> carrier;
    std::vector<float> balls;
    std::vector<Reach> reach_of_arm;
    std::vector<Reach> reach_of_body;  ///< of each obstacle's bodies
    std::vector<OwnGroup> own_groups;
    std::vector<double> still;  ///< speeds of own bodies when the caller gives none
    std::vector<LaneRange> ranges;
    std::vector<int> thin_pairs;
    std::vector<int> box_pairs;
    std::vector<LanePair> pairs;
  } scratch;
};

PassKernel fastest_pass() {
  return fastest(baseline::run_pass, avx2::run_pass);
}

ExactDistance::ExactDistance(const CellGeometry& geometry, PassKernel kernel)
    : storage_(std::make_unique<Storage>(geometry, kernel)) {}
ExactDistance::~ExactDistance() = default;
ExactDistance::ExactDistance(ExactDistance&&) noexcept = default;
ExactDistance& ExactDistance::operator=(ExactDistance&&) noexcept = default;

void ExactDistance::rebuild(const CellGeometry& geometry) {
  storage_ = std::make_unique<Storage>(geometry, storage_->kernel);
}

int ExactDistance::clearances(const CellPoses& poses, const InfluenceDistances& influence, std::span<Clearance> out) {
  int count = 0;
  const auto add = [&](const LanePair& pair, const ShapeDistance& found, int part) {
    if (count == static_cast<int>(out.size())) {
      if (!drop_farthest(out, found.distance)) return;
      --count;
    }
    const PassBody& own = storage_->bodies[pair.own];
    const PassBody& other = storage_->bodies[pair.other];
    out[count++] = {own.index, own.link,       other.counterpart, other.owner, other.index, other.link,
                    part,      found.distance, found.p_a_W,       found.p_b_W, found.n_W};
  };
  for (const LanePair& pair : storage_->find(poses, influence)) {
    if (pair.state == PairState::kFar) continue;
    if (pair.state == PairState::kMeasured) {
      const auto vector = [](const Quad& q) { return Eigen::Vector3d(q.x, q.y, q.z); };
      add(pair, {pair.n_W.w, vector(pair.p_own_W), vector(pair.p_other_W), vector(pair.n_W)}, 0);
    } else if (storage_->bodies[pair.other].cloud) {
      ShapeDistance balls[kMostBallPairs];
      const int found = storage_->measure_cloud(pair, balls);
      for (int part = 0; part < found; ++part) add(pair, balls[part], part);
    } else {
      const ShapeDistance found = storage_->measure(pair);
      if (found.distance < pair.limit) add(pair, found, 0);
    }
  }
  return count;
}

ShapeDistance ExactDistance::sweep_distance(const Clearance& obstacle, const CellPoses& poses,
                                            const Sweep& sweep) const {
  return storage_->measure_sweep(obstacle, poses, sweep);
}

ShapeDistance prepared_distance(const SweptCore& a, const Pose& X_WA, const SweptCore& b, const Pose& X_WB) {
  return distance(a, X_WA, b, X_WB);
}

ShapeDistance shape_distance(const world::Shape& a, const Pose& X_WA, const world::Shape& b, const Pose& X_WB) {
  if (const auto* points = std::get_if<world::Points>(&b)) {
    return cloud_distance({make_swept_core(a), X_WA}, *points->cloud, X_WB, std::numeric_limits<double>::infinity());
  }
  if (std::holds_alternative<world::Points>(a)) return exchanged(shape_distance(b, X_WB, a, X_WA));
  return distance(make_swept_core(a), X_WA, make_swept_core(b), X_WB);
}

}  // namespace hecaton::planner
