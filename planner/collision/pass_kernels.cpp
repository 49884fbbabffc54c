#include "planner/collision/pass_kernels.hpp"

#include "planner/collision/pass_cull.hpp"
#include "planner/collision/segment_kernels.hpp"

namespace hecaton::planner::HECATON_ISA {
namespace {

/// Rounding in a bound may not lose a pair that sits on its limit [m].
constexpr double kSlack = 1e-9;
/// Cores nearer than this [m] have no direction between them worth the name: not measured here.
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
