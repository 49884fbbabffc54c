#include "planner/global/kernel_robot.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <tuple>

#include "planner/collision/exact_distance.hpp"
#include "planner/local/parameters.hpp"

namespace hecaton::planner::global {
namespace {

using world::BoundingSphere;

constexpr double kRoundedUp = 1.0 + 1e-5;
/// Unit roundoff of floats.
constexpr double kRoundoff = 0x1p-24;
/// Largest error of sine_cosine() of float_lanes.hpp.
constexpr double kSineError = 2.5e-7;
/// Largest angle of a joint without limits for which rounding is bounded [rad].
constexpr double kLargestAngle = 10.0;
/// Entries of rotations this close to 0 or ±1 are made equal to them. It leaves out less than the rounding to floats.
constexpr double kNearlyWhole = 1e-9;
/// Error of a distance between two balls that are less than a few metres apart [m].
constexpr double kComparison = 1e-6;
/// Balls below one ball of a tree.
constexpr std::size_t kFanOut = 6;

/// Distance of p from an axis through the origin.
double axis_distance(const Eigen::Vector3d& axis, const Eigen::Vector3d& p) {
  return (p - axis.dot(p) * axis).norm();
}

/// Calls `raise` with the number of each axis before a link, and its lever to a ball on that link. Returns a ball in
/// the base's frame that contains it in all configurations. Walks from the link to the base. In each frame, a ball
/// about the frame's origin contains the ball for all values of the joints beyond it.
template <typename Raise>
BoundingSphere walk_to_base(const Arm& arm, int link, BoundingSphere ball, const Raise& raise) {
  const RobotModel& model = *arm.model;
  int axis = axes_before(model, link);
  for (; link >= 0; link = model.links[link].parent) {
    const Link& at = model.links[link];
    if (at.joint >= 0) {
      const bool prismatic = at.joint_type == JointType::kPrismatic;
      raise(--axis,
            static_cast<float>(kRoundedUp * (prismatic ? 1.0 : axis_distance(at.axis, ball.centre) + ball.radius)));
      ball.radius += ball.centre.norm();
      if (prismatic) ball.radius += largest_position(at, arm.limits);
      ball.centre = Eigen::Vector3d::Zero();
    }
    ball.centre = at.X_PJ * ball.centre;
  }
  return ball;
}

template <std::size_t N, typename Matrix>
std::array<float, N> floats(const Matrix& values) {
  std::array<float, N> result;
  for (std::size_t i = 0; i < N; ++i) result[i] = static_cast<float>(values.data()[i]);
  return result;
}

/// Radius of the largest ball about p that lies within the shape [m]; 0 if p lies outside. It equals the depth of p in
/// the convex shape.
double inner_radius(const SweptCore& core, const Eigen::Vector3d& p) {
  static const SweptCore point = make_swept_core(world::Sphere{0.0});
  const Pose at(Eigen::Translation3d{p});
  return std::max(0.0, -prepared_distance(point, at, core, Pose::Identity()).distance);
}

BoundingSphere tight_bound(const world::Shape& shape) {
  const auto* convex = std::get_if<world::Convex>(&shape);
  BoundingSphere rough = world::bounding_sphere(shape);
  if (convex == nullptr) return rough;
  const BoundingSphere sphere = bounding_sphere_of(convex->hull->vertices);
  return sphere.radius < rough.radius ? sphere : rough;
}

/// A link's kernel frame, and its pose in that frame.
struct LinkPlace {
  int frame = -1;
  Pose X_FL = Pose::Identity();
};

/// Bounds of the errors of a frame that floats compute, to first order; point_error() adds half as much again.
struct FrameError {
  double rotation = 0.0;  ///< of the matrix, Frobenius norm
  double origin = 0.0;    ///< [m]
  double farthest = 0.0;  ///< largest distance of the origin from O in any configuration [m]
};

/// Error of a point at `p` in a frame [m].
double point_error(const FrameError& frame, double p) {
  return 1.5 * (frame.origin + frame.rotation * p + kRoundoff * (p + 4.0 * (frame.farthest + 2.0 * p)));
}

/// A ball of a tree before its errors are known.
struct TreeBall {
  BoundingSphere ball;
  double inner = 0.0;
  int body = -1;
  std::vector<TreeBall> below;
};

BoundingSphere ball_around(const std::vector<TreeBall>& balls) {
  std::vector<Eigen::Vector3d> centres;
  for (const TreeBall& each : balls) centres.push_back(each.ball.centre);
  BoundingSphere around = bounding_sphere_of(centres);
  const auto radius_about = [&](const Eigen::Vector3d& centre) {
    double radius = 0.0;
    for (const TreeBall& each : balls) radius = std::max(radius, (each.ball.centre - centre).norm() + each.ball.radius);
    return radius;
  };
  // Steps towards the ball that reaches farthest.
  for (int i = 2; i < 200; ++i) {
    const auto farthest = std::max_element(balls.begin(), balls.end(), [&](const TreeBall& a, const TreeBall& b) {
      return (a.ball.centre - around.centre).norm() + a.ball.radius <
             (b.ball.centre - around.centre).norm() + b.ball.radius;
    });
    const Eigen::Vector3d away = farthest->ball.centre - around.centre;
    const double distance = away.norm();
    if (distance < 1e-12) break;
    around.centre += away * ((distance + farthest->ball.radius) / (distance * i));
  }
  around.radius = radius_about(around.centre);
  const Eigen::Vector3d middle = std::accumulate(centres.begin(), centres.end(), Eigen::Vector3d(0.0, 0.0, 0.0)) /
                                 static_cast<double>(centres.size());
  if (radius_about(middle) < around.radius) around = {middle, radius_about(middle)};
  return around;
}

/// At most kFanOut balls that contain the given ones, as trees.
std::vector<TreeBall> gathered(std::vector<TreeBall> balls) {
  if (balls.size() <= kFanOut) return balls;
  Eigen::AlignedBox3d extent;
  for (const TreeBall& each : balls) extent.extend(each.ball.centre);
  int axis = 0;
  extent.sizes().maxCoeff(&axis);
  std::stable_sort(balls.begin(), balls.end(),
                   [axis](const TreeBall& a, const TreeBall& b) { return a.ball.centre[axis] < b.ball.centre[axis]; });
  const auto half = static_cast<std::ptrdiff_t>(balls.size() / 2);
  std::vector<TreeBall> result;
  for (int side = 0; side < 2; ++side) {
    std::vector<TreeBall> part(std::make_move_iterator(side == 0 ? balls.begin() : balls.begin() + half),
                               std::make_move_iterator(side == 0 ? balls.begin() + half : balls.end()));
    part = gathered(std::move(part));
    if (part.size() <= kFanOut / 2) {
      result.insert(result.end(), std::make_move_iterator(part.begin()), std::make_move_iterator(part.end()));
      continue;
    }
    TreeBall parent;
    parent.ball = ball_around(part);
    const bool one_body =
        std::all_of(part.begin(), part.end(), [&](const TreeBall& each) { return each.body == part.front().body; });
    parent.body = one_body ? part.front().body : -1;
    parent.below = std::move(part);
    result.push_back(std::move(parent));
  }
  return result;
}

class Builder {
 public:
  Builder(const std::vector<CellGeometry>& planned, const Pose& X_OW, const CoverOptions& cover,
          const KernelPadding& padding)
      : planned_(planned), X_OW_(X_OW), cover_(cover), padding_(padding) {}

  BuiltRobot build() {
    for (const CellGeometry& geometry : planned_) robot().dimensions += geometry.own_arm().model->joints();
    if (robot().dimensions > kMaxDimensions) {
      throw std::invalid_argument("arms of " + std::to_string(robot().dimensions) +
                                  " joints in total cannot be planned together (at most " +
                                  std::to_string(kMaxDimensions) + ")");
    }
    int first_dimension = 0;
    for (const CellGeometry& geometry : planned_) {
      add_arm(geometry, first_dimension);
      first_dimension += geometry.own_arm().model->joints();
    }
    if (robot().frames.size() > kMaxFrames) {
      throw std::invalid_argument("arms of " + std::to_string(robot().frames.size()) +
                                  " moving links in total cannot be planned together (at most " +
                                  std::to_string(kMaxFrames) + ")");
    }
    if (robot().bodies.size() > kMaxBodies || robot().balls.size() > kMaxBalls) {
      throw std::invalid_argument("arms of " + std::to_string(robot().bodies.size()) + " bodies and " +
                                  std::to_string(robot().balls.size()) +
                                  " covering balls cannot be planned together (at most " + std::to_string(kMaxBodies) +
                                  " and " + std::to_string(kMaxBalls) + ")");
    }
    add_pairs();
    add_levers();
    for (int i = static_cast<int>(robot().links.size()) - 1; i >= 0; --i) {
      if (robot().links[i].frame >= 0) robot().order.push_back(i);
    }
    return std::move(built_);
  }

 private:
  KernelRobot& robot() { return built_.robot; }

  void add_arm(const CellGeometry& geometry, int first_dimension) {
    first_body_.push_back(static_cast<int>(robot().bodies.size()));
    const int arm_index = static_cast<int>(first_body_.size()) - 1;
    const Arm& arm = geometry.own_arm();
    first_frame_.push_back(static_cast<int>(robot().frames.size()));
    const std::vector<LinkPlace> places = add_frames(arm, first_dimension);
    // Links by what they are part of: a carried obstacle is a link of its own.
    std::map<std::pair<int, int>, std::vector<TreeBall>> parts;
    for (const Body& body : geometry.own_bodies()) {
      const LinkPlace& place = places[body.link];
      const Pose X_FS = place.X_FL * body.X_CS;
      const int index = static_cast<int>(robot().bodies.size());
      KernelBody& kernel_body = robot().bodies.emplace_back();
      kernel_body.frame = place.frame;
      kernel_body.round = std::holds_alternative<world::Sphere>(body.shape);
      built_.cores.push_back({make_swept_core(body.shape), X_FS});
      built_.arm_of_body.push_back(arm_index);
      const double reach = (place.X_FL * body.bound.centre).norm() + body.bound.radius;
      built_.rounding_of_body.push_back(point_error(error_of(place.frame), reach));
      parts[{body.link, body.obstacle}].push_back(tree_of(body.shape, index));
    }
    for (auto& [part, bodies] : parts) add_link(arm, places[part.first], part.first, std::move(bodies));
  }

  std::vector<LinkPlace> add_frames(const Arm& arm, int first_dimension) {
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
      places[i] = {static_cast<int>(robot().frames.size()), X_JZ.inverse()};
      add_frame(X_FZ, parent.frame, link, arm.limits);
      robot().frames.back().coordinate = first_dimension + link.joint;
    }
    return places;
  }

  void add_frame(const Pose& X_FZ, int parent, const Link& link, const JointLimits& limits) {
    const bool prismatic = link.joint_type == JointType::kPrismatic;
    KernelFrame& frame = robot().frames.emplace_back();
    frame.parent = parent;
    frame.prismatic = prismatic;
    frame.follows = link.follows;
    frame.multiplier = static_cast<float>(link.multiplier);
    frame.offset = static_cast<float>(link.offset);
    Eigen::Matrix3d rotation = X_FZ.linear();
    Eigen::Vector3d translation = X_FZ.translation();
    for (double& x : rotation.reshaped()) {
      for (const double whole : {-1.0, 0.0, 1.0}) {
        if (std::abs(x - whole) < kNearlyWhole) x = whole;
      }
    }
    for (double& x : translation) {
      if (std::abs(x) < kNearlyWhole) x = 0.0;
    }
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) {
        if (std::abs(rotation(row, column)) == 1.0) frame.axis[column] = row;
      }
    }
    frame.rotation = floats<9>(rotation);
    frame.translation = floats<3>(translation);

    // Errors of the frame: those of its parent, of the rounded constants, of the angle, its sine and cosine, and of
    // products and sums. An angle is a(1 − t) + bt: rounding of t, 1 − t, two products, the sum, the ends.
    // A follower's position has a product and a sum more, of numbers no larger than the share of its joint's.
    const double bound = largest_position(link, limits);
    const double largest =
        (std::isfinite(bound) ? bound : kLargestAngle * std::abs(link.multiplier)) + std::abs(link.offset);
    const double of_joint = 16.0 * kRoundoff * largest;
    const FrameError before = error_of(parent);
    FrameError& error = errors_.emplace_back();
    const double length = translation.norm() + (prismatic ? largest : 0.0);
    error.farthest = before.farthest + length;
    error.rotation =
        before.rotation + 4.0 * kNearlyWhole + 16.0 * kRoundoff + (prismatic ? 0.0 : 2.0 * (of_joint + kSineError));
    error.origin = before.origin + (before.rotation + kNearlyWhole) * length + (prismatic ? of_joint : 0.0) +
                   kRoundoff * (2.0 * length + 5.0 * error.farthest);
  }

  [[nodiscard]] const FrameError& error_of(int frame) const {
    static const FrameError none;
    return frame < 0 ? none : errors_[frame];
  }

  TreeBall tree_of(const world::Shape& shape, int body) const {
    const PlacedCore& placed = built_.cores[body];
    const auto ball_of = [&](const BoundingSphere& sphere) {
      TreeBall ball;
      ball.ball = {placed.X_FS * sphere.centre, sphere.radius};
      ball.inner = inner_radius(placed.core, sphere.centre);
      ball.body = body;
      return ball;
    };
    std::vector<TreeBall> cover;
    for (const BoundingSphere& sphere : sphere_cover(shape, cover_)) cover.push_back(ball_of(sphere));
    if (cover.size() == 1) return cover.front();
    TreeBall root = ball_of(tight_bound(shape));
    root.below = gathered(std::move(cover));
    return root;
  }

  void add_link(const Arm& arm, const LinkPlace& place, int link, std::vector<TreeBall> bodies) {
    const int index = static_cast<int>(robot().links.size());
    KernelLink& kernel_link = robot().links.emplace_back();
    kernel_link.frame = place.frame;
    kernel_link.ball = static_cast<int>(robot().balls.size());
    kernel_link.first = static_cast<int>(robot().bodies_of_links.size());
    kernel_link.count = static_cast<int>(bodies.size());
    for (const TreeBall& body : bodies) {
      robot().bodies_of_links.push_back(body.body);
      robot().bodies[body.body].link = index;
    }
    TreeBall root;
    if (bodies.size() == 1) {
      root = std::move(bodies.front());
    } else {
      root.ball = ball_around(bodies);
      root.below = gathered(std::move(bodies));
    }
    const int parent = place.frame;
    add_balls(root, error_of(parent), -1);
    const BoundingSphere on_link{place.X_FL.inverse() * root.ball.centre, root.ball.radius};
    BoundingSphere reach = walk_to_base(arm, link, on_link, [](int, float) {});
    reach.centre = X_OW_ * arm.X_WB * reach.centre;
    reach.radius += point_error(error_of(parent), reach.radius);
    built_.reach_of_link.push_back(reach);
    places_of_links_.push_back({&arm, link, place.X_FL.inverse()});
  }

  void add_balls(const TreeBall& tree, const FrameError& error, int parent_body) {
    const std::size_t index = robot().balls.size();
    KernelBall& ball = robot().balls.emplace_back();
    // Also of the ball's centre as another link sees it, and of comparisons.
    const double rounding = point_error(error, tree.ball.centre.norm() + tree.ball.radius) + kComparison;
    ball.centre = floats<3>(tree.ball.centre);
    ball.radius = static_cast<float>(kRoundedUp * (tree.ball.radius + rounding));
    ball.inner = static_cast<float>(std::max(0.0, tree.inner - 2.0 * rounding));
    robot().body_of_ball.push_back(tree.body);
    if (tree.body >= 0 && tree.body != parent_body) robot().bodies[tree.body].ball = static_cast<int>(index);
    for (const TreeBall& below : tree.below) add_balls(below, error, tree.body);
    robot().balls[index].next = static_cast<int>(robot().balls.size());
  }

  void add_pair(int a, int b, double padding) {
    if (robot().bodies[a].frame < 0 && robot().bodies[b].frame < 0) return;
    if (robot().bodies[a].frame > robot().bodies[b].frame) std::swap(a, b);
    robot().pairs.push_back({a, b, static_cast<float>(padding)});
  }

  void add_pairs() {
    for (std::size_t one = 0; one < planned_.size(); ++one) {
      for (const auto& [a, b] : planned_[one].self_pairs()) {
        const double padding = std::min(padding_.self, kSecurityShare * planned_[one].widest(a, b));
        add_pair(first_body_[one] + a, first_body_[one] + b, padding);
      }
      for (std::size_t two = one + 1; two < planned_.size(); ++two) add_pairs_between(one, two);
    }
    const auto links_of = [&](const KernelPair& pair) {
      return std::pair(robot().bodies[pair.a].link, robot().bodies[pair.b].link);
    };
    std::stable_sort(robot().pairs.begin(), robot().pairs.end(), [&](const KernelPair& one, const KernelPair& two) {
      return std::tuple(links_of(one), one.a, one.b) < std::tuple(links_of(two), two.a, two.b);
    });
    for (int i = 0; i < static_cast<int>(robot().pairs.size()); ++i) {
      const KernelPair& pair = robot().pairs[i];
      const auto [a, b] = links_of(pair);
      if (robot().link_pairs.empty() ||
          std::pair(robot().link_pairs.back().a, robot().link_pairs.back().b) != links_of(pair)) {
        KernelLinkPair& added = robot().link_pairs.emplace_back();
        added.a = a;
        added.b = b;
        added.first = i;
        added.chain = built_.arm_of_body[pair.a] == built_.arm_of_body[pair.b];
        if (added.chain) {
          const int frame = robot().links[a].frame;
          added.between = frame < 0 ? first_frame_[built_.arm_of_body[pair.a]]
                                    : std::min(frame + 1, static_cast<int>(robot().frames.size()) - 1);
        }
      }
      KernelLinkPair& last = robot().link_pairs.back();
      ++last.count;
      last.padding = std::max(last.padding, pair.padding);
    }
  }

  void add_pairs_between(std::size_t one, std::size_t two) {
    const auto end_of = [&](std::size_t arm) {
      return arm + 1 < first_body_.size() ? first_body_[arm + 1] : static_cast<int>(robot().bodies.size());
    };
    for (int a = first_body_[one]; a < end_of(one); ++a) {
      for (int b = first_body_[two]; b < end_of(two); ++b) {
        const bool fixed = robot().bodies[a].frame < 0 || robot().bodies[b].frame < 0;
        if (fixed && same_robot(planned_[one].own_arm(), planned_[two].own_arm())) continue;
        add_pair(a, b, padding_.between_arms);
      }
    }
  }

  /// Levers of links: of the points of all their bodies, and of the centres of all their balls.
  void add_levers() {
    const auto padded = [](std::size_t count) {
      return static_cast<int>((count + kTablePadding - 1) / kTablePadding * kTablePadding);
    };
    const int dimensions = static_cast<int>(robot().frames.size());
    robot().link_stride = padded(robot().links.size());
    robot().pair_stride = padded(robot().link_pairs.size());
    robot().link_levers.assign(static_cast<std::size_t>(robot().link_stride) * dimensions, 0.0F);
    robot().pair_levers.assign(static_cast<std::size_t>(robot().pair_stride) * dimensions, 0.0F);
    const std::vector<float> of_bodies = body_levers(planned_);
    const auto lever = [&](int link, int j) -> float& { return robot().link_levers[j * robot().link_stride + link]; };
    for (int i = 0; i < static_cast<int>(robot().bodies.size()); ++i) {
      for (int j = 0; j < dimensions; ++j) {
        float& longest = lever(robot().bodies[i].link, j);
        longest = std::max(longest, of_bodies[static_cast<std::size_t>(i) * dimensions + j]);
      }
    }
    for (int link = 0; link < static_cast<int>(robot().links.size()); ++link) {
      const LinkOrigin& origin = places_of_links_[link];
      const int first = first_frame_[built_.arm_of_body[robot().bodies_of_links[robot().links[link].first]]];
      const int root = robot().links[link].ball;
      for (int ball = root; ball < robot().balls[root].next; ++ball) {
        const auto& c = robot().balls[ball].centre;
        const Eigen::Vector3d centre = origin.X_LF * Eigen::Vector3d(c[0], c[1], c[2]);
        walk_to_base(*origin.arm, origin.link, {centre, 0.0}, [&](int joint, float value) {
          lever(link, first + joint) = std::max(lever(link, first + joint), value);
        });
      }
    }
    for (int i = 0; i < static_cast<int>(robot().link_pairs.size()); ++i) {
      const KernelLinkPair& pair = robot().link_pairs[i];
      for (int j = 0; j < dimensions; ++j) {
        const float one = lever(pair.a, j);
        const float two = lever(pair.b, j);
        // A joint that moves both links, of one arm, does not move them relative to each other.
        robot().pair_levers[static_cast<std::size_t>(j) * robot().pair_stride + i] =
            one > 0.0F && two > 0.0F ? 0.0F : one + two;
      }
    }
  }

  /// A link of an arm, and the pose of its kernel frame in it.
  struct LinkOrigin {
    const Arm* arm;
    int link;
    Pose X_LF;
  };

  const std::vector<CellGeometry>& planned_;
  Pose X_OW_;
  CoverOptions cover_;
  KernelPadding padding_;
  BuiltRobot built_;
  std::vector<int> first_body_;   ///< by geometry
  std::vector<int> first_frame_;  ///< by geometry
  std::vector<FrameError> errors_;
  std::vector<LinkOrigin> places_of_links_;
};

}  // namespace

std::vector<float> body_levers(const std::vector<CellGeometry>& planned) {
  const auto axes_of = [](const CellGeometry& geometry) {
    const std::vector<Link>& links = geometry.own_arm().model->links;
    return std::count_if(links.begin(), links.end(), [](const Link& link) { return link.joint >= 0; });
  };
  std::size_t axes = 0;
  std::size_t bodies = 0;
  for (const CellGeometry& geometry : planned) {
    axes += static_cast<std::size_t>(axes_of(geometry));
    bodies += geometry.own_bodies().size();
  }
  std::vector<float> levers(bodies * axes, 0.0F);
  float* row = levers.data();
  std::ptrdiff_t first = 0;
  for (const CellGeometry& geometry : planned) {
    for (const Body& body : geometry.own_bodies()) {
      walk_to_base(geometry.own_arm(), body.link, body.bound,
                   [&](int axis, float lever) { row[first + axis] = lever; });
      row += axes;
    }
    first += axes_of(geometry);
  }
  return levers;
}

BuiltRobot kernel_robot(const std::vector<CellGeometry>& planned, const Pose& X_OW, const CoverOptions& cover,
                        const KernelPadding& padding) {
  return Builder(planned, X_OW, cover, padding).build();
}

}  // namespace hecaton::planner::global
