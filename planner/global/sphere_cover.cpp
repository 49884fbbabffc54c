#include "planner/global/sphere_cover.hpp"

#include <algorithm>
#include <cmath>

#include "planner/global/convex_pieces.hpp"

namespace hecaton::planner::global {
namespace {

using world::BoundingSphere;

/// Along z: `count` balls with centres from −last to +last.
std::vector<BoundingSphere> row(int count, double last, double radius) {
  std::vector<BoundingSphere> balls;
  for (int i = 0; i < count; ++i) {
    const double z = count == 1 ? 0.0 : last * (2.0 * i / (count - 1) - 1.0);
    balls.push_back({Eigen::Vector3d(0.0, 0.0, z), radius});
  }
  return balls;
}

/// A ball of radius R around the axis covers the cylinder's surface for √(R² − r²) to either side; the outermost one
/// lies so far inside the cap's centre that R reaches the cap's pole.
std::vector<BoundingSphere> cover(const world::Capsule& capsule, const CoverOptions& options) {
  const double r = capsule.radius;
  for (int count = 1;; ++count) {
    const auto radius_for = [&](double inset) {
      const double half_gap = count == 1 ? 0.0 : (capsule.half_length - inset) / (count - 1);
      return std::max(std::hypot(r, half_gap), r + inset);
    };
    double inset = count == 1 ? capsule.half_length : 0.0;
    if (count > 1) {  // the two demands meet where r + inset = √(r² + half_gap²): the one grows, the other falls
      double low = 0.0;
      double high = capsule.half_length;
      for (int i = 0; i < 60; ++i) {
        inset = 0.5 * (low + high);
        (std::hypot(r, (capsule.half_length - inset) / (count - 1)) > r + inset ? low : high) = inset;
      }
    }
    const double radius = radius_for(inset);
    if (radius <= r + options.excess || count >= options.most) return row(count, capsule.half_length - inset, radius);
  }
}

std::vector<BoundingSphere> cover(const world::Cylinder& cylinder, const CoverOptions& options) {
  const double half_gap = std::sqrt(std::pow(cylinder.radius + options.excess, 2) - std::pow(cylinder.radius, 2));
  const int count = std::clamp(static_cast<int>(std::ceil(cylinder.half_length / half_gap)), 1, options.most);
  const double half_slice = cylinder.half_length / count;
  return row(count, cylinder.half_length - half_slice, std::hypot(cylinder.radius, half_slice));
}

struct Piece {
  ConvexPolyhedron polyhedron;
  BoundingSphere ball;
  double excess = 0.0;  ///< of the ball over the whole shape's faces [m]
};

Piece make_piece(ConvexPolyhedron polyhedron, const std::vector<HalfSpace>& faces) {
  Piece piece{std::move(polyhedron), {}, 0.0};
  piece.ball = enclosing_ball(piece.polyhedron.corners());
  for (const HalfSpace& face : faces) {
    piece.excess = std::max(piece.excess, face.normal.dot(piece.ball.centre) + piece.ball.radius - face.offset);
  }
  return piece;
}

/// Cut in the middle across the axis that leaves the smaller balls.
std::pair<Piece, Piece> halves(const Piece& piece, const std::vector<HalfSpace>& faces) {
  Eigen::AlignedBox3d extent;
  for (const auto& p : piece.polyhedron.corners()) extent.extend(p);
  std::pair<Piece, Piece> best;
  double least = HUGE_VAL;
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d normal = Eigen::Vector3d::Unit(axis);
    const double middle = extent.center()[axis];
    std::pair<Piece, Piece> two{make_piece(cut(piece.polyhedron, {normal, middle}), faces),
                                make_piece(cut(piece.polyhedron, {-normal, -middle}), faces)};
    const double largest = std::max(two.first.ball.radius, two.second.ball.radius);
    if (largest < least) {
      least = largest;
      best = std::move(two);
    }
  }
  return best;
}

std::vector<BoundingSphere> cover(const ConvexPolyhedron& whole, const CoverOptions& options) {
  const std::vector<HalfSpace> faces = half_spaces(whole);
  std::vector<Piece> pieces{make_piece(whole, faces)};
  while (static_cast<int>(pieces.size()) < options.most) {
    const auto worst = std::max_element(pieces.begin(), pieces.end(),
                                        [](const Piece& a, const Piece& b) { return a.excess < b.excess; });
    if (worst->excess <= options.excess) break;
    auto [first, second] = halves(*worst, faces);
    *worst = std::move(first);
    pieces.push_back(std::move(second));
  }
  std::vector<BoundingSphere> balls;
  for (const Piece& piece : pieces) balls.push_back(piece.ball);
  return balls;
}

}  // namespace

BoundingSphere enclosing_ball(const std::vector<Eigen::Vector3d>& points) {
  BoundingSphere ball;
  if (points.empty()) return ball;
  Eigen::AlignedBox3d box;
  for (const auto& p : points) box.extend(p);
  ball.centre = box.center();
  const auto farthest = [&] {
    return *std::max_element(points.begin(), points.end(), [&](const auto& a, const auto& b) {
      return (a - ball.centre).squaredNorm() < (b - ball.centre).squaredNorm();
    });
  };
  // Badoiu and Clarkson's steps towards the farthest point, ever shorter.
  for (int i = 2; i < 200; ++i) ball.centre += (farthest() - ball.centre) / i;
  ball.radius = (farthest() - ball.centre).norm();
  return ball;
}

std::vector<BoundingSphere> sphere_cover(const world::Shape& shape, const CoverOptions& options) {
  struct Visitor {
    const CoverOptions& options;
    std::vector<BoundingSphere> operator()(const world::Box& box) const { return cover(polyhedron_of(box), options); }
    std::vector<BoundingSphere> operator()(const world::Sphere& sphere) const {
      return {{Eigen::Vector3d::Zero(), sphere.radius}};
    }
    std::vector<BoundingSphere> operator()(const world::Capsule& capsule) const { return cover(capsule, options); }
    std::vector<BoundingSphere> operator()(const world::Cylinder& cylinder) const { return cover(cylinder, options); }
    std::vector<BoundingSphere> operator()(const world::Convex& convex) const {
      return cover(polyhedron_of(*convex.hull), options);
    }
  };
  return std::visit(Visitor{options}, shape);
}

}  // namespace hecaton::planner::global
