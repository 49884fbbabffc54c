#include "planner/collision/pass_kernels.hpp"

#include "planner/collision/segment_kernels.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

static_assert(kLanes == kPassLanes);

/// Rounding in a bound may not lose a pair that sits on its limit [m].
constexpr double kSlack = 1e-9;
/// Cores nearer than this [m] have no direction between them worth the name: not measured here.
constexpr double kTouching = 1e-8;

Lanes load(const Quad& quad) {
  return HECATON_ISA::load(&quad.x);
}
void store(Quad& quad, Lanes lanes) {
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

Lanes place_ball(const LanePass& pass, int body) {
  const Lanes centre = Columns(pass.carrier[body]).placed(pass.bodies[body].ball_C);
  store(pass.places[body].ball_W, centre);
  return centre;
}

void place_shape(const LanePass& pass, int body) {
  const LaneBody& from = pass.bodies[body];
  LanePlace& to = pass.places[body];
  const Columns X_WC(pass.carrier[body]);
  if (from.kind == BodyKind::kBox) {
    for (int i = 0; i < 3; ++i) store(to.box_W[i], X_WC.turned(from.box_C[i]));
    return;
  }
  const Lanes middle = X_WC.placed(from.middle_C);
  const Lanes half = X_WC.turned(from.axis_C) * from.axis_C.w;
  store(to.p_W, middle - half);
  store(to.q_W, middle + half);
}

/// One quantity of four bodies, a lane each.
Vector<Lanes> gather(const LanePass& pass, const int* bodies, Quad LanePlace::*quantity) {
  return transposed(load(pass.places[bodies[0]].*quantity), load(pass.places[bodies[1]].*quantity),
                    load(pass.places[bodies[2]].*quantity), load(pass.places[bodies[3]].*quantity));
}

template <typename Number>
Lanes lanes_of(const Number& number) {
  return Lanes{number(0), number(1), number(2), number(3)};
}

Vector<Lanes> all_lanes(const Quad& v) {
  return {all<Lanes>(v.x), all<Lanes>(v.y), all<Lanes>(v.z)};
}

/// Own bodies' common bounding box.
struct OwnBox {
  Vector<Lanes> low{all<Lanes>(HUGE_VAL), all<Lanes>(HUGE_VAL), all<Lanes>(HUGE_VAL)};
  Vector<Lanes> high{all<Lanes>(-HUGE_VAL), all<Lanes>(-HUGE_VAL), all<Lanes>(-HUGE_VAL)};

  void extend(const Vector<Lanes>& centre, double ball_radius) {
    const Vector<Lanes> radius{all<Lanes>(ball_radius), all<Lanes>(ball_radius), all<Lanes>(ball_radius)};
    low = min(low, centre - radius);
    high = max(high, centre + radius);
  }
  /// Squared distance of points to the box.
  [[nodiscard]] Lanes distance2(const Vector<Lanes>& points) const {
    const Vector<Lanes> out = max(max(low - points, points - high), Vector<Lanes>{});
    return dot(out, out);
  }
};

/// Adds the pairs of one other body with the own bodies that `pass.hits` names in its lane.
void add_pairs(LanePass& pass, int other, unsigned lane_bit) {
  place_shape(pass, other);
  for (int own = 0; own < pass.own_count; ++own) {
    if ((pass.hits[own] & lane_bit) == 0) continue;
    if (pass.own_moves[own] == 0 && pass.pairs_with_fixed[other] == 0) continue;
    LanePair& pair = pass.pairs[pass.pair_count++];
    pair.own = own;
    pair.other = other;
    pair.cull = pass.bodies[own].kind == BodyKind::kOther || pass.bodies[other].kind == BodyKind::kOther;
    pair.limit = max(pass.at_rest[other], pass.moving[other] + pass.per_speed[other] * pass.own_speed[own]);
  }
}

/// Which of four balls, a lane each, are near each own body: bit masks into `hits`, their union returned. (A negative
/// sum of limit and radii lets too much pass, never too little.)
unsigned near_own_bodies(const LanePass& pass, const Vector<Lanes>& centre, Lanes at_rest, Lanes moving,
                         Lanes per_speed) {
  const int count = pass.own_count;
  const LanePlace* const places = pass.places;
  const double* const radius = pass.radius;
  const double* const speed = pass.own_speed;
  unsigned* const hits = pass.hits;
  unsigned any = 0;
  for (int own = 0; own < count; ++own) {
    const Vector<Lanes> way = centre - all_lanes(places[own].ball_W);
    const Lanes sum = max(at_rest, moving + per_speed * speed[own]) + radius[own];
    const unsigned near = bits(dot(way, way) <= sum * sum);
    hits[own] = near;
    any |= near;
  }
  return any;
}

/// Adds the pairs whose bounding balls are near.
void cull(LanePass& pass) {
  OwnBox own_box;
  double top_speed = 0.0;
  for (int own = 0; own < pass.own_count; ++own) {
    own_box.extend(all_lanes(pass.places[own].ball_W), pass.radius[own]);
    top_speed = max(top_speed, pass.own_speed[own]);
  }
  for (int r = 0; r < pass.range_count; ++r) {
    for (int first = pass.ranges[r].first; first < pass.ranges[r].end; first += kLanes) {
      const Vector<Lanes> centre = transposed(place_ball(pass, first), place_ball(pass, first + 1),
                                              place_ball(pass, first + 2), place_ball(pass, first + 3));
      const Lanes slack = HECATON_ISA::load(pass.radius + first) + kSlack;
      const Lanes at_rest = HECATON_ISA::load(pass.at_rest + first) + slack;
      const Lanes moving = HECATON_ISA::load(pass.moving + first) + slack;
      const Lanes per_speed = HECATON_ISA::load(pass.per_speed + first);
      const Lanes farthest = max(at_rest, moving + per_speed * top_speed);
      if (bits(own_box.distance2(centre) <= farthest * farthest) == 0) continue;

      unsigned any = near_own_bodies(pass, centre, at_rest, moving, per_speed);
      for (int lane = 0; any != 0; ++lane, any >>= 1U) {
        if ((any & 1U) != 0) add_pairs(pass, first + lane, 1U << lane);
      }
    }
  }
}

/// Four pairs of a list; the last one repeated where the list ends.
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

/// Writes what was found of four pairs of cores: nearest points of the bodies that balls sweep along them.
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

  Boxes(const LanePass& pass, const int* bodies) : centre(gather(pass, bodies, &LanePlace::ball_W)) {
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

/// Drops pairs whose own bounding ball is too far from the box: most of those whose bounding balls meet.
int cull_boxes(LanePass& pass, int count) {
  int kept = 0;
  for (int first = 0; first < count; first += kLanes) {
    const Four four(pass, pass.box_pairs, first, count);
    const Boxes boxes(pass, four.other);
    const Vector<Lanes> centre = boxes.to_box(gather(pass, four.own, &LanePlace::ball_W));
    const Vector<Lanes> out = excess(centre, boxes.half);
    const Lanes sum = lanes_of([&](int i) { return four.pair[i]->limit + pass.radius[four.own[i]] + kSlack; });
    const unsigned near = bits(dot(out, out) <= sum * sum);
    for (int lane = 0; lane < kLanes && first + lane < count; ++lane) {
      const int pair = pass.box_pairs[first + lane];
      if ((near >> lane & 1U) != 0) {
        pass.box_pairs[kept++] = pair;
      } else {
        pass.pairs[pair].state = PairState::kFar;
      }
    }
  }
  return kept;
}

void measure_boxes(LanePass& pass, int count) {
  count = cull_boxes(pass, count);
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
  for (int own = 0; own < pass.own_count; ++own) {
    place_ball(pass, own);
    place_shape(pass, own);
  }
  cull(pass);
  int thin = 0;
  int boxes = 0;
  for (int i = 0; i < pass.pair_count; ++i) {
    const LanePair& pair = pass.pairs[i];
    if (pair.other >= pass.own_count && pass.bodies[pair.other].kind == BodyKind::kBox) {
      pass.box_pairs[boxes++] = i;
    } else {
      pass.thin_pairs[thin++] = i;
    }
  }
  measure_thin(pass, thin);
  measure_boxes(pass, boxes);
}

}  // namespace hecaton::planner::HECATON_ISA
