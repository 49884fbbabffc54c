#include "planner/collision/pass_kernels.hpp"

#include <bit>
#include <cstddef>

#include "planner/collision/segment_kernels.hpp"
#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

inline Lanes load(const Quad& quad) {
  return HECATON_ISA::load(&quad.x);
}
inline void store(Quad& quad, Lanes lanes) {
  HECATON_ISA::store(&quad.x, lanes);
}

/// The columns of a pose, a lane each for x, y, z.
struct Columns {
  Lanes x, y, z, t;
  explicit Columns(const double* X)
      : x(HECATON_ISA::load(X)),
        y(HECATON_ISA::load(X + 4)),
        z(HECATON_ISA::load(X + 8)),
        t(HECATON_ISA::load(X + 12)) {}
  [[nodiscard]] Lanes turned(const Quad& v) const { return x * v.x + y * v.y + z * v.z; }
  [[nodiscard]] Lanes placed(const Quad& p) const { return turned(p) + t; }
};

/// Centre of the bounding ball in W.
inline Lanes place_ball(const LanePass& pass, int body) {
  const LaneBody& from = pass.bodies[body];
  const Columns X_WC(pass.carrier[body]);
  return from.in_place ? X_WC.t : X_WC.placed(from.ball_C);
}

/// Writes the segment or box of `body` in W to its place.
inline void place_shape(const LanePass& pass, int body) {
  const LaneBody& from = pass.bodies[body];
  LanePlace& to = pass.places[body];
  const Columns X_WC(pass.carrier[body]);
  if (from.kind == BodyKind::kBox && from.in_place) {
    store(to.box_W[0], X_WC.x);
    store(to.box_W[1], X_WC.y);
    store(to.box_W[2], X_WC.z);
    store(to.centre_W, X_WC.t);
    return;
  }
  if (from.kind == BodyKind::kBox) {
    store(to.centre_W, X_WC.placed(from.ball_C));
    for (int i = 0; i < 3; ++i) store(to.box_W[i], X_WC.turned(from.box_C[i]));
    return;
  }
  const Lanes middle = X_WC.placed(from.middle_C);
  const Lanes half = X_WC.turned(from.axis_C) * from.axis_C.w;
  store(to.p_W, middle - half);
  store(to.q_W, middle + half);
}

static_assert(OwnGroup::kBodies == kFloatLanes);

inline Vector<FloatLanes> loaded(const float* x, const float* y, const float* z) {
  return {HECATON_ISA::load(x), HECATON_ISA::load(y), HECATON_ISA::load(z)};
}

/// Finds the pairs that may be near: one other body against eight own bodies at a time. It computes in floats, with
/// bounds rounded outwards; pairs that pass are measured in doubles, so that no distance depends on floats. The origin
/// is the centre of the first own body, so that floats resolve everything near it.
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
  /// Returns the distance of its ball from the origin along each axis.
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

  /// Tests the shape of one of the two bodies. Not inlined, to keep the surrounding loop small.
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

/// Keeps pairs at their limit that rounding in a bound would lose [m].
constexpr double kSlack = 1e-9;
/// Between cores nearer than this [m] the direction is rounding noise: the pair stays open.
constexpr double kTouching = 1e-8;

/// One quantity of four bodies, a lane each.
Vector<Lanes> gather(const LanePass& pass, const int* bodies, Quad LanePlace::*quantity) {
  return transposed(load(pass.places[bodies[0]].*quantity), load(pass.places[bodies[1]].*quantity),
                    load(pass.places[bodies[2]].*quantity), load(pass.places[bodies[3]].*quantity));
}

template <typename Number>
Lanes lanes_of(const Number& number) {
  return Lanes{number(0), number(1), number(2), number(3)};
}

/// Four pairs of a list, padded with its last pair.
struct Four {
  LanePair* pair[kLanes];
  int own[kLanes];
  int other[kLanes];

  Four(LanePass& pass, const int* list, int first, int count) {
    for (int lane = 0; lane < kLanes; ++lane) {
      pair[lane] = &pass.pairs[list[first + lane < count ? first + lane : count - 1]];
      own[lane] = pair[lane]->own;
      other[lane] = pair[lane]->other;
    }
  }
};

SegmentOf<Lanes> segments(const LanePass& pass, const int* bodies) {
  return {gather(pass, bodies, &LanePlace::p_W), gather(pass, bodies, &LanePlace::q_W)};
}

/// Writes the results of four pairs of cores: nearest points of the bodies that balls sweep along the cores.
void finish(const Four& four, const Gap<Lanes>& gap, Lanes own_radius, Lanes other_radius) {
  const Lanes core_distance = sqrt(dot(gap.way, gap.way));
  const Vector<Lanes> n = gap.way / core_distance;
  const Lanes distance = core_distance - own_radius - other_radius;
  const Vector<Lanes> p_own = gap.p_a + own_radius * n;
  const Vector<Lanes> p_other = gap.p_a + core_distance * n - other_radius * n;
  for (int lane = 0; lane < kLanes; ++lane) {
    LanePair& pair = *four.pair[lane];
    if (distance[lane] >= pair.limit + (pair.cull ? kSlack : 0.0)) {
      pair.state = PairState::kFar;
      continue;
    }
    pair.state = pair.cull || core_distance[lane] <= kTouching ? PairState::kOpen : PairState::kMeasured;
    pair.n_W = {n.x[lane], n.y[lane], n.z[lane], distance[lane]};
    pair.p_own_W = {p_own.x[lane], p_own.y[lane], p_own.z[lane], 0.0};
    pair.p_other_W = {p_other.x[lane], p_other.y[lane], p_other.z[lane], 0.0};
  }
}

Lanes radii(const LanePass& pass, const int* bodies) {
  return lanes_of([&](int i) { return pass.bodies[bodies[i]].middle_C.w; });
}

void measure_thin(LanePass& pass, int count) {
  for (int first = 0; first < count; first += kLanes) {
    const Four four(pass, pass.thin_pairs, first, count);
    finish(four, segment_segment(segments(pass, four.own), segments(pass, four.other)), radii(pass, four.own),
           radii(pass, four.other));
  }
}

/// Boxes of four bodies: poses and half extents.
struct Boxes {
  Vector<Lanes> axis[3];
  Vector<Lanes> centre;
  Vector<Lanes> half;

  Boxes(const LanePass& pass, const int* bodies) : centre(gather(pass, bodies, &LanePlace::centre_W)) {
    const auto axes = [&](int i) {
      return transposed(load(pass.places[bodies[0]].box_W[i]), load(pass.places[bodies[1]].box_W[i]),
                        load(pass.places[bodies[2]].box_W[i]), load(pass.places[bodies[3]].box_W[i]));
    };
    const auto extents = [&](int i) { return lanes_of([&](int k) { return pass.bodies[bodies[k]].box_C[i].w; }); };
    for (int i = 0; i < 3; ++i) axis[i] = axes(i);
    half = {extents(0), extents(1), extents(2)};
  }
  [[nodiscard]] Vector<Lanes> to_box(const Vector<Lanes>& p_W) const {
    const Vector<Lanes> way = p_W - centre;
    return {dot(axis[0], way), dot(axis[1], way), dot(axis[2], way)};
  }
  [[nodiscard]] Vector<Lanes> turned_to_world(const Vector<Lanes>& v) const {
    return v.x * axis[0] + v.y * axis[1] + v.z * axis[2];
  }
};

void measure_boxes(LanePass& pass, int count) {
  for (int first = 0; first < count; first += kLanes) {
    const Four four(pass, pass.box_pairs, first, count);
    const Boxes boxes(pass, four.other);
    const SegmentOf<Lanes> own_W = segments(pass, four.own);
    const Gap<Lanes> gap = segment_box(SegmentOf<Lanes>{boxes.to_box(own_W.p), boxes.to_box(own_W.q)}, boxes.half);
    finish(four, {boxes.turned_to_world(gap.p_a) + boxes.centre, boxes.turned_to_world(gap.way)}, radii(pass, four.own),
           Lanes{});
  }
}

}  // namespace

void run_pass(LanePass& pass) {
  const Cull cull(pass);
  measure_thin(pass, cull.thin_count());
  measure_boxes(pass, cull.box_count());
}

}  // namespace hecaton::planner::HECATON_ISA
