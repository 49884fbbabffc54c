#include "world/sim/obstacle_dynamics.hpp"

#include <algorithm>
#include <cmath>

#include "world/model/scene_checks.hpp"
#include "world/sim/bullet_shape.hpp"

namespace hecaton::world {
namespace {

// Bullet multiplies the two bodies' coefficients. With 1 on everything that is not dynamic, a dynamic body's own
// coefficients hold against floor, arms and scripted obstacles; two dynamic bodies meet with the product.
constexpr double kNeutralFriction = 1.0;
constexpr double kNeutralRestitution = 1.0;

constexpr double kMaxSubstep = 0.005;   // [s]
constexpr double kMinSubstep = 0.0005;  // [s]

// A body below both speeds rests. Bullet's own thresholds would stop a body that still rolls or tilts.
constexpr double kRestingSpeed = 0.002;  // [m/s]
constexpr double kRestingTurn = 0.02;    // [rad/s]

constexpr int kDynamicGroup = 1;
constexpr int kFixedGroup = 2;  // floor, arms, static and scripted obstacles: meet dynamic bodies only

std::unique_ptr<btDefaultCollisionConfiguration> small_configuration() {
  // Bullet's defaults reserve 5 MB; beyond these pools it allocates one by one.
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = 64;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 128;
  auto configuration = std::make_unique<btDefaultCollisionConfiguration>(info);
  // A face that lands flat needs several contact points: with one corner alone it would tip over.
  configuration->setPlaneConvexMultipointIterations();
  configuration->setConvexConvexMultipointIterations();
  return configuration;
}

/// [m], by the divergence theorem: each triangle of a face forms a tetrahedron with the origin.
Eigen::Vector3d centroid(const ConvexHull& hull) {
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double volumes = 0.0;
  for (const auto& face : hull.faces) {
    for (std::size_t i = 2; i < face.size(); ++i) {
      const auto& a = hull.vertices[face[0]];
      const auto& b = hull.vertices[face[i - 1]];
      const auto& c = hull.vertices[face[i]];
      const double six_volume = a.dot(b.cross(c));
      moment += six_volume * (a + b + c) / 4.0;
      volumes += six_volume;
    }
  }
  return moment / volumes;
}

/// Bullet takes each shape's origin as its centre of mass; for a hull the two differ.
std::vector<PlacedShape> about_centroids(std::span<const PlacedShape> shapes) {
  std::vector<PlacedShape> centred(shapes.begin(), shapes.end());
  for (PlacedShape& placed : centred) {
    const auto* convex = std::get_if<Convex>(&placed.shape);
    if (!convex) continue;
    auto hull = std::make_shared<ConvexHull>(*convex->hull);
    const Eigen::Vector3d centre = centroid(*hull);
    for (Eigen::Vector3d& vertex : hull->vertices) vertex -= centre;
    placed = {Convex{hull}, placed.X_BS * Eigen::Translation3d(centre)};
  }
  return centred;
}

/// Bullet's rolling friction disturbs flat contacts: stacks of boxes would creep by millimetres a second.
bool can_roll(const PlacedShape& placed) {
  return !std::holds_alternative<Box>(placed.shape) && !std::holds_alternative<Convex>(placed.shape);
}

/// Radius of a ball that fits into the shape around its centre, or around the centroid of a hull [m].
double inner_radius(const Shape& shape) {
  struct Visitor {
    double operator()(const Box& box) const { return box.half_extents.minCoeff(); }
    double operator()(const Sphere& sphere) const { return sphere.radius; }
    double operator()(const Capsule& capsule) const { return capsule.radius; }
    double operator()(const Cylinder& cylinder) const { return std::min(cylinder.radius, cylinder.half_length); }
    double operator()(const Convex& convex) const {
      const ConvexHull& hull = *convex.hull;
      const Eigen::Vector3d centre = centroid(hull);
      double least = bounding_sphere(Shape(convex)).radius;
      for (const auto& face : hull.faces) {
        const auto& corner = hull.vertices[face[0]];
        const Eigen::Vector3d normal = (hull.vertices[face[1]] - corner).cross(hull.vertices[face[2]] - corner);
        if (normal.norm() > 0.0) least = std::min(least, std::abs(normal.normalized().dot(centre - corner)));
      }
      return least;
    }
    double operator()(const Points& points) const { return points.cloud->radius(); }
  };
  return std::visit(Visitor{}, shape);
}

btRigidBody::btRigidBodyConstructionInfo massless(btCollisionShape* shape) {
  btRigidBody::btRigidBodyConstructionInfo info(0.0, nullptr, shape);
  info.m_friction = kNeutralFriction;
  info.m_restitution = kNeutralRestitution;
  return info;
}

}  // namespace

void ArmTrack::measure(std::span<const Pose> X_WL, const Pose& X_WT) {
  X_WL_.assign(X_WL.begin(), X_WL.end());
  X_WT_ = X_WT;
  if (known_) return;
  X_WL_before_ = X_WL_;
  X_WT_before_ = X_WT_;
  known_ = true;
}

void ArmTrack::end_step(double dt) {
  if (!known_ || dt <= 0.0) return;
  tool_velocity_ = twist_between(X_WT_before_, X_WT_, dt);
  X_WL_before_ = X_WL_;
  X_WT_before_ = X_WT_;
}

MotionState carried(const MotionState& tool, const Pose& X_TO) {
  const Pose X_WO = tool.X_WO * X_TO;
  return {X_WO, {tool.velocity.at(X_WO.translation(), tool.X_WO.translation()), tool.velocity.angular}};
}

bool is_free(const Obstacle& obstacle) {
  return !obstacle.attachment && std::holds_alternative<DynamicMotion>(obstacle.motion);
}

PhysicsSpace::PhysicsSpace(double floor_z, const Eigen::Vector3d& gravity)
    : configuration_(small_configuration()),
      dispatcher_(std::make_unique<btCollisionDispatcher>(configuration_.get())),
      broadphase_(std::make_unique<btDbvtBroadphase>()),
      solver_(std::make_unique<btSequentialImpulseConstraintSolver>()),
      world_(std::make_unique<btDiscreteDynamicsWorld>(dispatcher_.get(), broadphase_.get(), solver_.get(),
                                                       configuration_.get())),
      floor_shape_(std::make_unique<btStaticPlaneShape>(btVector3(0, 0, 1), floor_z)),
      floor_(std::make_unique<btRigidBody>(massless(floor_shape_.get()))) {
  solver_->setRandSeed(0);
  // With one direction of friction, along the residual velocity, resting bodies would creep.
  world_->getSolverInfo().m_solverMode |=
      SOLVER_USE_2_FRICTION_DIRECTIONS | SOLVER_DISABLE_VELOCITY_DEPENDENT_FRICTION_DIRECTION;
  world_->getSolverInfo().m_numIterations = 20;
  world_->getDispatchInfo().m_deterministicOverlappingPairs = true;
  world_->setForceUpdateAllAabbs(false);  // bodies that stand or sleep keep their boxes
  world_->setGravity(to_bullet(gravity));
  world_->addRigidBody(floor_.get(), kFixedGroup, kDynamicGroup);
}

PhysicsSpace::~PhysicsSpace() {
  world_->removeRigidBody(floor_.get());
}

void PhysicsSpace::step(double h) {
  world_->stepSimulation(h, 0);
}

void PhysicsSpace::wake_at(const btRigidBody& body) {
  struct Wake final : btBroadphaseAabbCallback {
    bool process(const btBroadphaseProxy* proxy) override {
      static_cast<btCollisionObject*>(proxy->m_clientObject)->activate();  // does nothing unless it is dynamic
      return true;
    }
  };
  // Contacts begin a little before bodies touch.
  const btVector3 near(gContactBreakingThreshold, gContactBreakingThreshold, gContactBreakingThreshold);
  btVector3 least;
  btVector3 greatest;
  body.getAabb(least, greatest);
  Wake wake;
  broadphase_->aabbTest(least - near, greatest + near, wake);
}

RigidBody::RigidBody(PhysicsSpace& space, std::span<const PlacedShape> shapes, const Pose& X_WO, bool guided)
    : space_(space) {
  build_shape(shapes);
  body_ = std::make_unique<btRigidBody>(massless(compound_.get()));
  if (guided) {
    body_->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    body_->setActivationState(DISABLE_DEACTIVATION);
  }
  place({X_WO, {}}, 1.0);
  space_.bullet().addRigidBody(body_.get(), kFixedGroup, kDynamicGroup);
  space_.wake_at(*body_);
}

RigidBody::RigidBody(PhysicsSpace& space, std::span<const PlacedShape> shapes, const DynamicMotion& motion,
                     const MotionState& start)
    : space_(space) {
  build_shape(about_centroids(shapes));
  const btVector3 inertia = centre_on_mass(shapes, motion.mass);
  btRigidBody::btRigidBodyConstructionInfo info(motion.mass, nullptr, compound_.get(), inertia);
  info.m_friction = motion.friction;
  if (std::any_of(shapes.begin(), shapes.end(), can_roll)) {
    info.m_rollingFriction = motion.rolling_friction;
    info.m_spinningFriction = motion.rolling_friction;
  }
  info.m_restitution = motion.restitution;
  info.m_startWorldTransform = to_bullet(start.X_WO * X_OM_);
  body_ = std::make_unique<btRigidBody>(info);
  body_->setSleepingThresholds(kRestingSpeed, kRestingTurn);
  for (const PlacedShape& placed : shapes) safe_motion_ = std::max(safe_motion_, inner_radius(placed.shape));
  const Eigen::Vector3d centre_W = start.X_WO * X_OM_.translation();
  body_->setLinearVelocity(to_bullet(start.velocity.at(centre_W, start.X_WO.translation())));
  body_->setAngularVelocity(to_bullet(start.velocity.angular));
  space_.bullet().addRigidBody(body_.get(), kDynamicGroup, kDynamicGroup | kFixedGroup);
  space_.wake_at(*body_);
}

RigidBody::~RigidBody() {
  space_.wake_at(*body_);  // a sleeping body would stay in the air without its support
  space_.bullet().removeRigidBody(body_.get());
}

void RigidBody::build_shape(std::span<const PlacedShape> shapes) {
  compound_ = std::make_unique<btCompoundShape>(true, static_cast<int>(shapes.size()));
  for (const PlacedShape& placed : shapes) {
    if (const auto* points = std::get_if<Points>(&placed.shape)) {
      parts_.push_back(make_bullet_shape(Sphere{points->cloud->radius()}));
      for (const Eigen::Vector3f& point : points->cloud->points()) {
        compound_->addChildShape(to_bullet(Pose(placed.X_BS * Eigen::Translation3d(point.cast<double>()))),
                                 parts_.back().get());
      }
      continue;
    }
    parts_.push_back(make_bullet_shape(placed.shape));
    compound_->addChildShape(to_bullet(placed.X_BS), parts_.back().get());
  }
}

btVector3 RigidBody::centre_on_mass(std::span<const PlacedShape> shapes, double mass) {
  double total = 0.0;
  for (const PlacedShape& placed : shapes) total += volume(placed.shape);
  std::vector<btScalar> masses;
  for (const PlacedShape& placed : shapes) masses.push_back(mass * volume(placed.shape) / total);

  btTransform X_OM;
  btVector3 inertia;
  compound_->calculatePrincipalAxisTransform(masses.data(), X_OM, inertia);
  for (int i = 0; i < compound_->getNumChildShapes(); ++i) {
    compound_->updateChildTransform(i, X_OM.inverse() * compound_->getChildTransform(i), false);
  }
  compound_->recalculateLocalAabb();
  X_OM_ = from_bullet(X_OM);
  return inertia;
}

void RigidBody::place(const MotionState& state, double h) {
  // Bullet derives a kinematic body's velocity from its pose one substep ago.
  body_->setWorldTransform(to_bullet(state.X_WO));
  body_->setInterpolationWorldTransform(to_bullet(extrapolate(state.X_WO, state.velocity, -h)));
}

MotionState RigidBody::state() const {
  const Pose X_WM = from_bullet(body_->getWorldTransform());
  if (!awake()) return {X_WM * X_OM_.inverse(), {}};
  const Twist at_centre{from_bullet(body_->getLinearVelocity()), from_bullet(body_->getAngularVelocity())};
  MotionState state;
  state.X_WO = X_WM * X_OM_.inverse();
  state.velocity = {at_centre.at(state.X_WO.translation(), X_WM.translation()), at_centre.angular};
  return state;
}

std::span<const int> ObstacleDynamics::advance(const DynamicsInput& input, std::span<ObstacleState> states, double dt) {
  moved_.clear();
  if (dt <= 0.0 || input.free.empty()) return moved_;
  make_missing(input, states);

  const int count = substeps(input, dt);
  const double h = dt / count;
  for (int i = 0; i < count; ++i) {
    place(input, dt, i * h, h);
    space_->step(h);
  }
  for (const int i : input.free) {
    if (!bodies_[i]->may_have_moved()) continue;
    const MotionState state = bodies_[i]->state();
    states[i] = {state.X_WO, state.velocity, 0.0};
    moved_.push_back(i);
  }
  return moved_;
}

int ObstacleDynamics::substeps(const DynamicsInput& input, double dt) const {
  double shortest = kMaxSubstep;
  const double fall = input.scene.gravity.norm() * dt;
  for (const int i : input.free) {
    const RigidBody& body = *bodies_[i];
    const double speed = body.awake() ? body.speed() + fall : 0.0;
    if (speed * shortest > body.safe_motion()) shortest = body.safe_motion() / speed;
  }
  // Rounding must not add a substep to a dt of a whole number of substeps.
  return std::max(1, static_cast<int>(std::ceil(dt / std::max(shortest, kMinSubstep) - 1e-9)));
}

void ObstacleDynamics::make_missing(const DynamicsInput& input, std::span<const ObstacleState> states) {
  if (complete_) return;
  if (!space_) space_ = std::make_unique<PhysicsSpace>(input.scene.floor_z, input.scene.gravity);
  complete_ = true;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    if (bodies_[i]) continue;
    const Obstacle& obstacle = input.scene.obstacles[i];
    if (is_free(obstacle)) {
      const auto& motion = std::get<DynamicMotion>(obstacle.motion);
      const MotionState start{states[i].X_WO, states[i].velocity};
      bodies_[i] = std::make_unique<RigidBody>(*space_, obstacle.shapes, motion, start);
    } else if (!obstacle.attachment || input.carriers[i]->known()) {
      const bool guided = obstacle.attachment || is_scripted(obstacle.motion);
      bodies_[i] = std::make_unique<RigidBody>(*space_, obstacle.shapes, states[i].X_WO, guided);
    } else {
      complete_ = false;
    }
  }
  arm_bodies_.resize(input.arms.size());
  for (std::size_t arm = 0; arm < input.arms.size(); ++arm) {
    if (!arm_bodies_[arm].empty()) continue;
    if (!input.tracks[arm].known()) {
      complete_ = false;
      continue;
    }
    for (const auto& part : input.arms[arm].parts) {
      const Pose& X_WL = input.tracks[arm].X_WL()[part.link];
      arm_bodies_[arm].push_back(std::make_unique<RigidBody>(*space_, std::span(&part.shape, 1), X_WL, true));
    }
  }
}

void ObstacleDynamics::place(const DynamicsInput& input, double dt, double elapsed, double h) {
  for (const int i : input.guided) {
    const Obstacle& obstacle = input.scene.obstacles[i];
    if (!bodies_[i]) continue;
    bodies_[i]->place(obstacle.attachment ? carried(input.carriers[i]->tool_at(dt, elapsed), obstacle.attachment->X_TO)
                                          : motion_at(obstacle, input.time + elapsed),
                      h);
  }
  for (std::size_t arm = 0; arm < arm_bodies_.size(); ++arm) {
    for (std::size_t part = 0; part < arm_bodies_[arm].size(); ++part) {
      const int link = input.arms[arm].parts[part].link;
      arm_bodies_[arm][part]->place(input.tracks[arm].link_at(link, dt, elapsed), h);
    }
  }
}

}  // namespace hecaton::world
