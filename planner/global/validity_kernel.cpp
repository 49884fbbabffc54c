#include "planner/global/validity_kernel.hpp"

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::global::HECATON_ISA {
namespace {

using namespace hecaton::planner::HECATON_ISA;
using V = FloatLanes;
static_assert(kFloatLanes == kWidth);

V abs(V x) {
  return max(x, -x);
}
V sqrt(V x) {
#if defined(__AVX2__)
  return _mm256_sqrt_ps(x);
#else
  for (int i = 0; i < kFloatLanes; ++i) x[i] = std::sqrt(x[i]);
  return x;
#endif
}
/// Reduction in three steps instead of seven: each body of each block needs it six times.
float least(V x) {
  x = min(x, __builtin_shufflevector(x, x, 4, 5, 6, 7, 0, 1, 2, 3));
  x = min(x, __builtin_shufflevector(x, x, 2, 3, 0, 1, 6, 7, 4, 5));
  x = min(x, __builtin_shufflevector(x, x, 1, 0, 3, 2, 5, 4, 7, 6));
  return x[0];
}

struct Vec {
  V x, y, z;
};
Vec operator-(const Vec& a, const Vec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
V dot(const Vec& a, const Vec& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
V along(const Vec& a, const float* axis) {
  return a.x * axis[0] + a.y * axis[1] + a.z * axis[2];
}

/// Columns of the rotation, and the origin.
struct Frame {
  Vec x, y, z, p;
};

Vec turned(const Frame& f, const float* v) {
  return {f.x.x * v[0] + f.y.x * v[1] + f.z.x * v[2], f.x.y * v[0] + f.y.y * v[1] + f.z.y * v[2],
          f.x.z * v[0] + f.y.z * v[1] + f.z.z * v[2]};
}
Vec placed(const Frame& f, const float* v) {
  const Vec t = turned(f, v);
  return {t.x + f.p.x, t.y + f.p.y, t.z + f.p.z};
}
Vec constant(const float* v) {
  return {all_floats(v[0]), all_floats(v[1]), all_floats(v[2])};
}

/// Cody and Waite's reduction by π/2 in two parts, then minimax polynomials on ±π/4: within 2·10⁻⁷ for |x| ≤ 10³.
void sine_cosine(V x, V& sine, V& cosine) {
  const V quarters = x * 0.636619772F + 12582912.0F;  // 1.5 · 2²³: adding it rounds to a whole number
  const V n = quarters - 12582912.0F;
  const V r = (x - n * 1.5707855225F) - n * 1.0804334124e-5F;
  const V z = r * r;
  const V s = r + r * (z * (-1.6666654611e-1F + z * (8.3321608736e-3F + z * -1.9515295891e-4F)));
  const V c =
      1.0F - 0.5F * z + z * z * (4.166664568298827e-2F + z * (-1.388731625493765e-3F + z * 2.443315711809948e-5F));
  FloatMask quadrant;
  std::memcpy(&quadrant, &quarters, sizeof(quadrant));
  const FloatMask odd = (quadrant & 1) != 0;
  const V a = odd ? c : s;
  const V b = odd ? s : c;
  sine = (quadrant & 2) != 0 ? -a : a;
  cosine = ((quadrant + 1) & 2) != 0 ? -b : b;
}

/// Bits of lanes: may collide, and certainly collides.
struct Hits {
  unsigned maybe = 0;
  unsigned sure = 0;

  void add(const Hits& other) {
    maybe |= other.maybe;
    sure |= other.sure;
  }
};

/// Checks eight configurations. If the covering spheres are clear, so is the shape; if a sphere inside the shape
/// collides, so does the shape. Pairs between these cases are collected, and get exact distances only if nothing else
/// decides. kSwept: checks the segments around the configurations (KernelSweep).
template <bool kSwept>
class Block {
 public:
  Block(const KernelRobot& robot, const KernelWorld& world, const ExactCheck& exact, const KernelSweep& sweep,
        const V* q)
      : robot_(robot), world_(world), exact_(exact), sweep_(sweep) {
    std::memset(known_, 0, robot.bodies.size());
    for (int i = 0; i < robot.dimensions; ++i) place(i, q[i]);
  }

  /// Returns the lanes that collide; with `any_is_enough`, at least one of them.
  unsigned collisions(bool any_is_enough) {
    const auto decided = [&] { return (hits_ | maybe_) == kAll || (any_is_enough && hits_ != 0); };
    for (const int body : robot_.order) {
      world_hits(body);
      if (decided()) return hits_;
    }
    for (std::size_t i = 0; i < robot_.pairs.size(); ++i) {
      const KernelPair& pair = robot_.pairs[i];
      const float growth = kSwept ? sweep_.pair_growth[i] : 0.0F;
      note(pair_hits(pair, pair.padding + growth), pair.a, pair.b, false, growth);
      if (decided()) return hits_;
    }
    for (int i = 0; i < undecided_count_ && !decided(); ++i) resolve(undecided_[i], any_is_enough);
    return hits_;
  }
  /// After collisions(): lanes that neither collide nor are proven free. kSwept only.
  [[nodiscard]] unsigned maybe() const { return maybe_; }

 private:
  static constexpr unsigned kAll = 0xFF;
  /// Undecided pairs beyond this number count as collisions.
  static constexpr int kMaxUndecided = 64;

  struct Undecided {
    int body;
    int other;  ///< body or obstacle
    bool of_world;
    unsigned lanes;
    float growth;  ///< [m]
  };

  void note(const Hits& hits, int body, int other, bool of_world, float growth) {
    hits_ |= hits.sure;
    const unsigned undecided = hits.maybe & ~hits.sure & ~maybe_;
    if (undecided == 0) return;
    if (undecided_count_ < kMaxUndecided && (!kSwept || sweep_.exact)) {
      undecided_[undecided_count_++] = {body, other, of_world, undecided, growth};
    } else if (kSwept) {
      maybe_ |= undecided;
    } else {
      hits_ |= undecided;
    }
  }

  void resolve(const Undecided& pair, bool any_is_enough) {
    for (unsigned left = pair.lanes & ~hits_ & ~maybe_; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      float frame[12];
      float other[12];
      lane_frame(pair.body, lane, frame);
      if (!pair.of_world) lane_frame(pair.other, lane, other);
      const double distance = pair.of_world
                                  ? exact_.from_obstacle(exact_.context, pair.body, frame, pair.other) - padding()
                                  : exact_.from_body(exact_.context, pair.body, frame, pair.other, other);
      hits_ |= distance <= 0.0 ? 1U << lane : 0U;
      if (distance <= 0.0 && any_is_enough) return;
      if (kSwept && distance <= pair.growth) maybe_ |= 1U << lane;
    }
  }

  [[nodiscard]] float padding() const { return kSwept ? sweep_.padding : world_.padding; }
  [[nodiscard]] float growth_of(int body) const { return kSwept ? sweep_.growth[body] : 0.0F; }

  void lane_frame(int body, int lane, float* out) const {
    const int frame = robot_.bodies[body].frame;
    if (frame < 0) {
      for (int i = 0; i < 12; ++i) out[i] = i == 0 || i == 4 || i == 8 ? 1.0F : 0.0F;
      return;
    }
    const Frame& f = frames_[frame];
    const Vec* columns[] = {&f.x, &f.y, &f.z, &f.p};
    for (int i = 0; i < 4; ++i) {
      out[3 * i] = columns[i]->x[lane];
      out[3 * i + 1] = columns[i]->y[lane];
      out[3 * i + 2] = columns[i]->z[lane];
    }
  }

  void place(int i, V q) {
    const KernelFrame& frame = robot_.frames[i];
    const float* r = frame.rotation.data();
    Frame& out = frames_[i];
    if (frame.parent < 0) {
      out = {constant(r), constant(r + 3), constant(r + 6), constant(frame.translation.data())};
    } else {
      const Frame& parent = frames_[frame.parent];
      out = {turned(parent, r), turned(parent, r + 3), turned(parent, r + 6), placed(parent, frame.translation.data())};
    }
    if (frame.prismatic) {
      out.p = {out.p.x + q * out.z.x, out.p.y + q * out.z.y, out.p.z + q * out.z.z};
      return;
    }
    V s, c;
    sine_cosine(q, s, c);
    const Vec x = out.x;
    const Vec y = out.y;
    out.x = {x.x * c + y.x * s, x.y * c + y.y * s, x.z * c + y.z * s};
    out.y = {y.x * c - x.x * s, y.y * c - x.y * s, y.z * c - x.z * s};
  }

  [[nodiscard]] Vec centre(int frame, const KernelSphere& sphere) const {
    return frame < 0 ? constant(sphere.centre.data()) : placed(frames_[frame], sphere.centre.data());
  }

  /// Centres of a body's bounding sphere and of its covering spheres, computed at the first use.
  const Vec& bound_of(int body) {
    if ((known_[body] & 1U) == 0) {
      bounds_[body] = centre(robot_.bodies[body].frame, robot_.bodies[body].bound);
      known_[body] |= 1U;
    }
    return bounds_[body];
  }
  const Vec* spheres_of(int index) {
    const KernelBody& body = robot_.bodies[index];
    if ((known_[index] & 2U) == 0) {
      for (int i = body.first; i < body.first + body.count; ++i) spheres_[i] = centre(body.frame, robot_.spheres[i]);
      known_[index] |= 2U;
    }
    return spheres_ + body.first;
  }

  /// The box around the bounding sphere of all lanes selects the obstacles to check, eight at a time.
  void world_hits(int index) {
    const KernelBody& body = robot_.bodies[index];
    const Vec& bound = bound_of(index);
    const float growth = growth_of(index);
    const float around = padding() + growth;
    const float r = body.bound.radius + around;
    const V low_x = all_floats(least(bound.x) - r), high_x = all_floats(r - least(-bound.x));
    const V low_y = all_floats(least(bound.y) - r), high_y = all_floats(r - least(-bound.y));
    const V low_z = all_floats(least(bound.z) - r), high_z = all_floats(r - least(-bound.z));
    for (std::size_t group = 0; group < world_.boxes.size(); ++group) {
      const auto& box = world_.boxes[group];
      const auto side = [&](std::size_t i) { return load(box[i].data()); };
      unsigned near = bits((side(0) <= high_x) & (side(3) >= low_x) & (side(1) <= high_y) & (side(4) >= low_y) &
                           (side(2) <= high_z) & (side(5) >= low_z));
      for (; near != 0; near &= near - 1) {
        const int obstacle = static_cast<int>(group) * kWidth + __builtin_ctz(near);
        const KernelObstacle& met = world_.obstacles[obstacle];
        // Lanes that are known to collide are not checked again.
        const float reach = r + met.bound_radius;
        const Vec d = bound - constant(met.bound_centre.data());
        if ((bits(dot(d, d) < all_floats(reach * reach)) & ~hits_) == 0) continue;
        note(obstacle_hits(index, bound, met, around), index, obstacle, true, growth);
      }
    }
  }

  Hits obstacle_hits(int index, const Vec& bound, const KernelObstacle& obstacle, float around) {
    const KernelBody& body = robot_.bodies[index];
    const Hits near = sphere_hits(bound, body.bound, obstacle, around);
    if ((near.maybe & ~hits_) == 0 || body.count == 1) return near;
    const Vec* spheres = spheres_of(index);
    Hits hits;
    for (int i = 0; i < body.count; ++i) {
      hits.add(sphere_hits(spheres[i], robot_.spheres[body.first + i], obstacle, around));
    }
    return hits;
  }

  /// `around`: added to the radius of the sphere [m].
  Hits sphere_hits(const Vec& p, const KernelSphere& sphere, const KernelObstacle& o, float around) const {
    const Vec d = p - constant(o.centre.data());
    const V zero{};
    const auto nearer = [](V distance2, float radius, float inner) {
      return Hits{bits(distance2 < all_floats(radius * radius)), bits(distance2 < all_floats(inner * inner))};
    };
    const float radius = sphere.radius + around;
    const float inner = sphere.inner;
    switch (o.kind) {
      case ObstacleKind::kSphere:
        return nearer(dot(d, d), radius + o.half[0], inner + o.half[0]);
      case ObstacleKind::kBox: {
        const Vec out{max(abs(along(d, &o.axes[0])) - o.half[0], zero),
                      max(abs(along(d, &o.axes[3])) - o.half[1], zero),
                      max(abs(along(d, &o.axes[6])) - o.half[2], zero)};
        return nearer(dot(out, out), radius, inner);
      }
      case ObstacleKind::kCapsule: {
        const V x = along(d, &o.axes[0]);
        const V y = along(d, &o.axes[3]);
        const V z = max(abs(along(d, &o.axes[6])) - o.half[2], zero);
        return nearer(x * x + y * y + z * z, radius + o.half[0], inner + o.half[0]);
      }
      case ObstacleKind::kCylinder: {
        const V x = along(d, &o.axes[0]);
        const V y = along(d, &o.axes[3]);
        const V z = max(abs(along(d, &o.axes[6])) - o.half[2], zero);
        const V side = max(sqrt(x * x + y * y) - o.half[0], zero);
        return nearer(side * side + z * z, radius, inner);
      }
      case ObstacleKind::kConvex: {
        V most = all_floats(-1e30F);
        for (int i = o.first; i < o.first + o.count; ++i) {
          const KernelPlane& plane = world_.planes[i];
          most = max(most, along(p, plane.normal.data()) - plane.offset);
        }
        // The distance to the farthest plane is a lower bound of that to the polyhedron, and exact only inside it.
        return {bits(most < radius), inner > 0.0F ? bits(most < zero) : 0U};
      }
    }
    return {kAll, kAll};
  }

  /// `around`: added to the distance at which two spheres touch [m].
  Hits pair_hits(const KernelPair& pair, float around) {
    const KernelBody& a = robot_.bodies[pair.a];
    const KernelBody& b = robot_.bodies[pair.b];
    const auto distance2 = [](const Vec& p, const Vec& q) {
      const Vec d = p - q;
      return dot(d, d);
    };
    const auto within = [](V d2, float radius) { return bits(d2 < all_floats(radius * radius)); };
    const Vec& bound_b = bound_of(pair.b);
    const unsigned near = within(distance2(bound_of(pair.a), bound_b), a.bound.radius + b.bound.radius + around);
    if ((near & ~hits_) == 0) return {};
    const Vec* spheres_a = spheres_of(pair.a);
    const Vec* spheres_b = spheres_of(pair.b);
    Hits hits;
    for (int i = 0; i < a.count; ++i) {
      const KernelSphere& sphere = robot_.spheres[a.first + i];
      const unsigned meets = within(distance2(spheres_a[i], bound_b), sphere.radius + b.bound.radius + around);
      if ((meets & ~hits_) == 0) continue;
      for (int k = 0; k < b.count; ++k) {
        const KernelSphere& other = robot_.spheres[b.first + k];
        const V d2 = distance2(spheres_a[i], spheres_b[k]);
        hits.maybe |= within(d2, sphere.radius + other.radius + around);
        if (sphere.inner > 0.0F && other.inner > 0.0F) hits.sure |= within(d2, sphere.inner + other.inner);
      }
    }
    return hits;
  }

  const KernelRobot& robot_;
  const KernelWorld& world_;
  const ExactCheck& exact_;
  const KernelSweep& sweep_;
  unsigned hits_ = 0;
  unsigned maybe_ = 0;
  int undecided_count_ = 0;
  Undecided undecided_[kMaxUndecided];
  Frame frames_[kMaxFrames];
  unsigned char known_[kMaxBodies];  ///< bit 0: of bounds_, bit 1: of spheres_
  Vec bounds_[kMaxBodies];
  Vec spheres_[kMaxSpheres];
};

void to_lanes(const KernelRobot& robot, const float* q, int stride, V* lanes) {
  for (int j = 0; j < robot.dimensions; ++j) {
    for (int lane = 0; lane < kWidth; ++lane) lanes[j][lane] = q[lane * stride + j];
  }
}

unsigned collisions(const KernelRobot& robot, const KernelWorld& world, const ExactCheck& exact, const float* q,
                    int stride) {
  V lanes[kMaxDimensions];
  to_lanes(robot, q, stride, lanes);
  return Block<false>(robot, world, exact, {}, lanes).collisions(false);
}

SweepHits swept(const KernelRobot& robot, const KernelWorld& world, const ExactCheck& exact, const KernelSweep& sweep,
                const float* q, int stride) {
  V lanes[kMaxDimensions];
  to_lanes(robot, q, stride, lanes);
  Block<true> block(robot, world, exact, sweep, lanes);
  const unsigned sure = block.collisions(true);
  return {sure, block.maybe()};
}

bool edge_free(const KernelRobot& robot, const KernelWorld& world, const ExactCheck& exact, const float* a,
               const float* b, int blocks) {
  const V lane_start = V{1, 2, 3, 4, 5, 6, 7, 8} * static_cast<float>(blocks);
  const float step = 1.0F / static_cast<float>(blocks * kWidth);
  V lanes[kMaxDimensions];
  for (int block = 0; block < blocks; ++block) {
    const V t = (lane_start - static_cast<float>(block)) * step;
    for (int j = 0; j < robot.dimensions; ++j) lanes[j] = a[j] * (1.0F - t) + b[j] * t;
    if (Block<false>(robot, world, exact, {}, lanes).collisions(true) != 0) return false;
  }
  return true;
}

}  // namespace

extern const ValidityKernel kValidity{collisions, edge_free, swept};

}  // namespace hecaton::planner::global::HECATON_ISA
