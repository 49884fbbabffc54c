#pragma once
/// Which pairs of a pass may be near, in floats: bounds that are rounded outwards. What they let pass is measured in
/// doubles, so that no distance depends on them.

#include <bit>
#include <cstddef>

#include "planner/collision/pass_places.hpp"

namespace hecaton::planner::HECATON_ISA {

static_assert(OwnGroup::kBodies == kFloatLanes);

inline Vector<FloatLanes> loaded(const float* x, const float* y, const float* z) {
  return {HECATON_ISA::load(x), HECATON_ISA::load(y), HECATON_ISA::load(z)};
}
/// Finds the pairs that may be near, an other body against eight own ones at a time. All lengths are taken from the
/// first own body's centre on, so that floats are fine enough for everything that is near it.
class Cull {
 public:
  explicit Cull(LanePass& pass) : pass_(pass), groups_((pass.own_count + kFloatLanes - 1) / kFloatLanes) {
    for (; thin_count_ < pass.pair_count; ++thin_count_) pass.thin_pairs[thin_count_] = thin_count_;
    if (pass.own_count == 0) return;
    origin_ = place_ball(pass, 0);
    Lanes farthest{};
    for (int own = 0; own < pass.own_count; ++own) farthest = max(farthest, place_own(own));
    extent_ = static_cast<float>(max(max(farthest[0], farthest[1]), farthest[2]));
    for (int r = 0; r < pass.range_count; ++r) look_at(pass.ranges[r]);
  }

  [[nodiscard]] int thin_count() const { return thin_count_; }
  [[nodiscard]] int box_count() const { return box_count_; }

 private:
  /// How far its ball is from the origin along each axis.
  Lanes place_own(int own) {
    OwnGroup& group = pass_.own_groups[own / kFloatLanes];
    const int lane = own % kFloatLanes;
    const Lanes centre = place_ball(pass_, own) - origin_;
    put(rounded(centre), lane, group.ball_x, group.ball_y, group.ball_z);
    group.speed[lane] = static_cast<float>(pass_.own_speed[own]);
    place_shape(pass_, own);
    return max(centre, -centre);
  }

  static void put(FourFloats v, int lane, float* x, float* y, float* z) {
    x[lane] = v[0];
    y[lane] = v[1];
    z[lane] = v[2];
  }

  void look_at(const LaneRange& range) {
    for (int other = range.first; other < range.end; ++other) {
      HECATON_ISA::store(ball_of(other), rounded(place_ball(pass_, other) - origin_));
    }
    if (!range.reach_of_each) set_reach(*range.reach);
    const OwnGroup* const groups_end = pass_.own_groups + groups_;
    for (int other = range.first; other < range.end; ++other) {
      const Reach& reach = range.reach_of_each ? range.reach[other - range.first] : *range.reach;
      if (range.reach_of_each) set_reach(reach);
      const float* const ball = ball_of(other);
      const float radius = pass_.radius[other];
      for (const OwnGroup* own = pass_.own_groups; own != groups_end; ++own) {
        if (const unsigned near = near_balls(*own, ball, radius); near != 0) look_closer(other, *own, near, reach);
      }
    }
  }

  void set_reach(const Reach& reach) {
    const FloatLanes at_rest = all_floats(static_cast<float>(reach.at_rest));
    const FloatLanes moving = all_floats(static_cast<float>(reach.moving));
    const FloatLanes per_speed = all_floats(static_cast<float>(reach.per_speed));
    for (int g = 0; g < groups_; ++g) {
      OwnGroup& own = pass_.own_groups[g];
      const FloatLanes distance = max(at_rest, moving + per_speed * HECATON_ISA::load(own.speed));
      const FloatLanes near = distance + kOutwards * (distance + all_floats(extent_));
      HECATON_ISA::store(own.near, near);
      HECATON_ISA::store(own.near_ball, near + HECATON_ISA::load(own.ball_radius));
    }
  }

  /// Bit i: own bounding ball i and the other one may be near.
  static unsigned near_balls(const OwnGroup& own, const float* ball, float radius) {
    const FloatLanes x = all_floats(ball[0]) - HECATON_ISA::load(own.ball_x);
    const FloatLanes y = all_floats(ball[1]) - HECATON_ISA::load(own.ball_y);
    const FloatLanes z = all_floats(ball[2]) - HECATON_ISA::load(own.ball_z);
    const FloatLanes sum = HECATON_ISA::load(own.near_ball) + all_floats(radius);
    return bits(x * x + y * y + z * z <= sum * sum);
  }

  /// Those that may still be near when one of the two shapes is looked at. Not inlined: the loop around it is tight.
  [[gnu::noinline]] void look_closer(int other, const OwnGroup& own, unsigned near, const Reach& reach) {
    near &= pass_.pairs_with_fixed[other] == 0 ? own.moving : own.bodies;
    place_shape(pass_, other);
    near &= bits(pass_.bodies[other].kind == BodyKind::kBox ? near_box(other, own) : near_capsule(other, own));
    if (near != 0) add_pairs(other, static_cast<int>(&own - pass_.own_groups) * kFloatLanes, near, reach);
  }

  [[nodiscard]] float* ball_of(int other) const { return pass_.ball + std::ptrdiff_t{4} * other; }

  /// Own bounding balls against a box.
  [[nodiscard]] FloatMask near_box(int other, const OwnGroup& own) const {
    const LanePlace& place = pass_.places[other];
    const float* const ball = ball_of(other);
    const FloatLanes x = all_floats(ball[0]) - HECATON_ISA::load(own.ball_x);
    const FloatLanes y = all_floats(ball[1]) - HECATON_ISA::load(own.ball_y);
    const FloatLanes z = all_floats(ball[2]) - HECATON_ISA::load(own.ball_z);
    FloatLanes out2{};
    for (int i = 0; i < 3; ++i) {
      const FourFloats axis = rounded(load(place.box_W[i]));
      const FloatLanes along = x * all_floats(axis[0]) + y * all_floats(axis[1]) + z * all_floats(axis[2]);
      const FloatLanes half = all_floats(static_cast<float>(pass_.bodies[other].box_C[i].w));
      const FloatLanes out = max(max(along, -along) - half, FloatLanes{});
      out2 += out * out;
    }
    const FloatLanes sum = HECATON_ISA::load(own.near_ball) + all_floats(kOutwards * pass_.radius[other]);
    return out2 <= sum * sum;
  }

  /// Own capsules against the bounding ball of another body.
  [[nodiscard]] FloatMask near_capsule(int other, const OwnGroup& own) {
    if (!segments_placed_) place_segments();
    const Vector<FloatLanes> d = loaded(own.d_x, own.d_y, own.d_z);
    const float* const ball = ball_of(other);
    const Vector<FloatLanes> centre{all_floats(ball[0]), all_floats(ball[1]), all_floats(ball[2])};
    const Vector<FloatLanes> way = centre - loaded(own.p_x, own.p_y, own.p_z);
    const FloatLanes t = min(max(dot(way, d) * HECATON_ISA::load(own.per_length2), FloatLanes{}), all_floats(1.0F));
    const Vector<FloatLanes> gap = way - t * d;
    const FloatLanes sum =
        HECATON_ISA::load(own.near) + HECATON_ISA::load(own.capsule_radius) + all_floats(pass_.radius[other]);
    return dot(gap, gap) <= sum * sum;
  }

  void place_segments() {
    for (int body = 0; body < pass_.own_count; ++body) {
      OwnGroup& own = pass_.own_groups[body / kFloatLanes];
      const int lane = body % kFloatLanes;
      const LanePlace& place = pass_.places[body];
      const FourFloats d = rounded(load(place.q_W) - load(place.p_W));
      put(rounded(load(place.p_W) - origin_), lane, own.p_x, own.p_y, own.p_z);
      put(d, lane, own.d_x, own.d_y, own.d_z);
      const float length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      own.per_length2[lane] = length2 > 0.0F ? 1.0F / length2 : 0.0F;
    }
    segments_placed_ = true;
  }

  void add_pairs(int other, int first, unsigned near, const Reach& reach) {
    const bool box = pass_.bodies[other].kind == BodyKind::kBox;
    for (; near != 0; near &= near - 1) {
      const int own = first + std::countr_zero(near);
      (box ? pass_.box_pairs[box_count_++] : pass_.thin_pairs[thin_count_++]) = pass_.pair_count;
      LanePair& pair = pass_.pairs[pass_.pair_count++];
      pair.own = own;
      pair.other = other;
      pair.cull = pass_.bodies[own].kind == BodyKind::kOther || pass_.bodies[other].kind == BodyKind::kOther;
      pair.limit = max(reach.at_rest, reach.moving + reach.per_speed * pass_.own_speed[own]);
    }
  }

  LanePass& pass_;
  int groups_;
  int thin_count_ = 0;
  int box_count_ = 0;
  Lanes origin_{};
  float extent_ = 0.0F;  ///< of own balls' centres from the origin, along any axis
  bool segments_placed_ = false;
};

}  // namespace hecaton::planner::HECATON_ISA
