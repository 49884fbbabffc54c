#include "planner/methods/sensed_cspace/direction_kernel.hpp"

#include <numbers>

#include "planner/simd/lanes.hpp"

// A link of length l and width w touches the obstacle O if its axis meets O ⊕ w, which is O grown by a disc of radius
// w. These are the directions from the joint to K = (O ⊕ w) ∩ (disc of radius l about the joint). O, O ⊕ w and K are
// convex. So the directions are one interval, less than π wide unless K contains the joint. Its ends belong to points
// of K of three kinds:
// - a tangent touches the disc about a corner of O;
// - the circle of radius l crosses that disc;
// - the circle crosses a side that is moved outwards by w.
// All such points lie in K, so the outermost two directions are the ends (docs/explanation/0011-sensed-cspace.md).

namespace hecaton::planner::cspace::HECATON_ISA {
namespace {

using namespace hecaton::planner::HECATON_ISA;

struct Flat {
  Lanes x, y;
};
Lanes dot(const Flat& a, const Flat& b) {
  return a.x * b.x + a.y * b.y;
}
/// Positive: b is counter-clockwise from a.
Lanes cross(const Flat& a, const Flat& b) {
  return a.x * b.y - a.y * b.x;
}
Flat either(LaneMask mask, const Flat& yes, const Flat& no) {
  return {select(mask, yes.x, no.x), select(mask, yes.y, no.y)};
}

/// Taylor series after a reduction to |z| ≤ tan(π/8). The error is below 5·10⁻¹⁰ rad.
Lanes atan2(const Flat& v) {
  constexpr double kTanEighth = 0.41421356237309503;
  const Lanes ax = max(v.x, -v.x);
  const Lanes ay = max(v.y, -v.y);
  const Lanes small = min(ax, ay);
  const Lanes large = max(ax, ay);
  const LaneMask steep = small > kTanEighth * large;
  const Lanes z = select(steep, small - large, small) / select(steep, small + large, large);
  const Lanes q = z * z;
  Lanes sum = all<Lanes>(-1.0 / 19.0);
  for (const double k :
       {1.0 / 17.0, -1.0 / 15.0, 1.0 / 13.0, -1.0 / 11.0, 1.0 / 9.0, -1.0 / 7.0, 1.0 / 5.0, -1.0 / 3.0}) {
    sum = sum * q + k;
  }
  Lanes angle = z + z * q * sum + select(steep, all<Lanes>(std::numbers::pi / 4.0), Lanes{});
  angle = select(ay > ax, std::numbers::pi / 2.0 - angle, angle);
  angle = select(v.x < 0.0, std::numbers::pi - angle, angle);
  return select(v.y < 0.0, -angle, angle);
}

/// The interval of directions of the points of K found so far.
struct Seen {
  Flat right{}, left{};
  LaneMask any{};

  void add(LaneMask valid, const Flat& to_right, const Flat& to_left) {
    right = either(valid & (~any | (cross(to_right, right) > 0.0)), to_right, right);
    left = either(valid & (~any | (cross(left, to_left) > 0.0)), to_left, left);
    any |= valid;
  }
};

struct Group {
  Flat joint;
  double length, width;
  Seen seen = {};
  LaneMask surrounded = {};  ///< the joint itself is in O ⊕ w
  LaneMask cut = {};         ///< the circle of radius l may cut O ⊕ w: then its sides matter

  void look_at(const Point& corner) {
    const Flat d{corner.x - joint.x, corner.y - joint.y};
    const Lanes s2 = dot(d, d);
    surrounded |= s2 <= width * width;
    // The visible part of the disc ends at ±γ: d turned by γ is (s cos γ) d ± (s sin γ) d⊥ over s.
    const LaneMask tangent = s2 <= length * length + width * width;  // sin γ = w/s                      eq. 5, 6
    const Lanes s_cos = (s2 + (length * length - width * width)) * (0.5 / length);  // else the law of cosines
    const Lanes known = select(tangent, all<Lanes>(width), s_cos);
    const Lanes other = sqrt(max(s2 - known * known, Lanes{}));
    const Lanes along = select(tangent, other, s_cos);
    const Lanes across = select(tangent, all<Lanes>(width), other);
    const Flat forward{along * d.x, along * d.y};
    const Flat aside{-across * d.y, across * d.x};
    seen.add(s2 <= (length + width) * (length + width), {forward.x - aside.x, forward.y - aside.y},
             {forward.x + aside.x, forward.y + aside.y});
    cut |= ~tangent;
  }

  void look_at(const Edge& edge) {
    const Flat d{edge.start.x - joint.x, edge.start.y - joint.y};
    const Lanes ahead = d.x * edge.outward.x + d.y * edge.outward.y + width;  // of the side moved outwards
    const Lanes before = d.x * edge.along.x + d.y * edge.along.y;             // of its start
    const Lanes half_chord2 = length * length - ahead * ahead;
    const Lanes half_chord = sqrt(max(half_chord2, Lanes{}));
    const Flat foot{ahead * edge.outward.x, ahead * edge.outward.y};
    const Flat chord{half_chord * edge.along.x, half_chord * edge.along.y};
    const auto on_side = [&](Lanes place) {
      return (half_chord2 >= 0.0) & (place >= before) & (place <= before + edge.length);
    };
    const Flat there{foot.x + chord.x, foot.y + chord.y};
    const Flat back{foot.x - chord.x, foot.y - chord.y};
    seen.add(on_side(half_chord), there, there);
    seen.add(on_side(-half_chord), back, back);
    surrounded |= (ahead >= 0.0) & (ahead <= width) & (before <= 0.0) & (before + edge.length >= 0.0);
  }
};

LaneMask inside(const ConvexPiece& obstacle, const Flat& joint) {
  LaneMask behind_all = ~LaneMask{};
  for (const Edge& edge : obstacle.edges) {
    behind_all &= (joint.x - edge.start.x) * edge.outward.x + (joint.y - edge.start.y) * edge.outward.y <= 0.0;
  }
  return behind_all;
}

}  // namespace

void touching_directions(const DirectionQuery& query, int count, double* right, double* left) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const ConvexPiece& obstacle = *query.obstacle;
  for (int i = 0; i < count; i += kLanes) {
    Group group{{load(query.joint_x + i), load(query.joint_y + i)}, query.length, query.width};
    for (const Point& corner : obstacle.corners) group.look_at(corner);
    // Without a cut, sides lie between the tangents to their corners, unless the obstacle surrounds the joint.
    const double most = obstacle.radius + query.width;
    const Flat middle{obstacle.centre.x - group.joint.x, obstacle.centre.y - group.joint.y};
    if (bits(group.cut | (dot(middle, middle) <= most * most)) != 0) {
      for (const Edge& edge : obstacle.edges) group.look_at(edge);
      if (obstacle.corners.size() > 2) group.surrounded |= inside(obstacle, group.joint);
    }
    const Flat forward{load(query.forward_x + i), load(query.forward_y + i)};
    const auto angle = [&](const Flat& direction) {
      return atan2({dot(forward, direction), cross(forward, direction)});
    };
    const Lanes nothing = all<Lanes>(kTurn);
    store(right + i, select(group.surrounded, -nothing, select(group.seen.any, angle(group.seen.right), nothing)));
    store(left + i, select(group.surrounded, nothing, select(group.seen.any, angle(group.seen.left), -nothing)));
  }
}

}  // namespace hecaton::planner::cspace::HECATON_ISA
