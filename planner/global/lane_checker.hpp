#pragma once
/// Part of the collision kernel, compiled once per instruction set: robot and world for as many configurations as there
/// are lanes. Included by validity_kernel.cpp only.

#include "planner/global/validity_kernel.hpp"
#include "planner/simd/float_lanes.hpp"
#include "world/model/point_nodes.hpp"

namespace hecaton::planner::global::HECATON_ISA {

using namespace hecaton::planner::HECATON_ISA;
using V = Floats;

struct Vec {
  V x, y, z;
};
inline Vec operator+(const Vec& a, const Vec& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec operator-(const Vec& a, const Vec& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline V dot(const Vec& a, const Vec& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}
inline V along(const Vec& a, const float* axis) {
  return a.x * axis[0] + (a.y * axis[1] + a.z * axis[2]);
}
inline Vec constant(const float* v) {
  return {all(v[0]), all(v[1]), all(v[2])};
}
inline Vec next_lane(const Vec& v) {
  using hecaton::planner::HECATON_ISA::next_lane;
  return {next_lane(v.x), next_lane(v.y), next_lane(v.z)};
}
using hecaton::planner::HECATON_ISA::next_lane;

/// Columns of the rotation, and the origin.
struct Frame {
  Vec x, y, z, p;

  [[nodiscard]] const Vec& axis(int i) const { return i == 0 ? x : i == 1 ? y : z; }
};
inline Vec turned(const Frame& f, const float* v) {
  return {f.x.x * v[0] + (f.y.x * v[1] + f.z.x * v[2]), f.x.y * v[0] + (f.y.y * v[1] + f.z.y * v[2]),
          f.x.z * v[0] + (f.y.z * v[1] + f.z.z * v[2])};
}
inline Vec placed(const Frame& f, const float* v) {
  return {f.p.x + f.x.x * v[0] + (f.y.x * v[1] + f.z.x * v[2]), f.p.y + f.x.y * v[0] + (f.y.y * v[1] + f.z.y * v[2]),
          f.p.z + f.x.z * v[0] + (f.y.z * v[1] + f.z.z * v[2])};
}
/// v in the frame f.
inline Vec seen_from(const Frame& f, const Vec& v) {
  const Vec d = v - f.p;
  return {dot(f.x, d), dot(f.y, d), dot(f.z, d)};
}

/// Nodes that a search in a tree of points has still to visit: fifteen for each of its levels, at most.
inline constexpr int kMostOpenNodes = 128;

/// Views of KernelMemory::storage.
struct Tables {
  Frame* frames;
  Vec* centres;   ///< of balls, in O
  Vec* relative;  ///< of balls, in the frame of another link
  float* link_speed;
  float* link_bend;
  float* link_beyond;
  float* pair_speed;
  float* pair_bend;
  float* pair_beyond;
  float* before;          ///< by frame: sum of the turns of the frames of its arm before it
  std::uint32_t* known;   ///< by ball: epoch of `centres`
  std::uint32_t* viewed;  ///< by ball: epoch of `relative`

  static std::size_t floats_needed(const KernelRobot& robot) {
    const std::size_t balls = robot.balls.size();
    const std::size_t frames = robot.frames.size();
    const std::size_t lanes = 12 * frames + 6 * balls;
    const auto tables = 3 * static_cast<std::size_t>(robot.link_stride + robot.pair_stride);
    return kTablePadding + lanes * kFloats + tables + frames + 1 + 2 * balls;
  }
  Tables(const KernelRobot& robot, KernelMemory& memory) {
    auto address = reinterpret_cast<std::uintptr_t>(memory.storage.data());
    constexpr std::uintptr_t kAlignment = kTablePadding * sizeof(float);
    address = (address + kAlignment - 1) / kAlignment * kAlignment;
    auto* at = reinterpret_cast<float*>(address);
    const auto take = [&at](std::size_t count) {
      float* from = at;
      at += count;
      return from;
    };
    const std::size_t balls = robot.balls.size();
    const std::size_t frame_count = robot.frames.size();
    frames = reinterpret_cast<Frame*>(take(frame_count * 12 * kFloats));
    centres = reinterpret_cast<Vec*>(take(balls * 3 * kFloats));
    relative = reinterpret_cast<Vec*>(take(balls * 3 * kFloats));
    for (float** table : {&link_speed, &link_bend, &link_beyond}) *table = take(robot.link_stride);
    for (float** table : {&pair_speed, &pair_bend, &pair_beyond}) *table = take(robot.pair_stride);
    before = take(frame_count + 1);
    known = reinterpret_cast<std::uint32_t*>(take(balls));
    viewed = reinterpret_cast<std::uint32_t*>(take(balls));
  }
};

/// The links of one robot at kFloats configurations. kWay: not the configurations count but the straight ways of all
/// points from each to the next. The last lane's way is its point.
template <bool kWay>
class LaneChecker {
 public:
  explicit LaneChecker(const KernelScene& scene)
      : robot_(scene.robot), world_(scene.world), memory_(scene.memory), tables_(scene.robot, scene.memory) {}

  [[nodiscard]] const Tables& tables() const { return tables_; }

  /// Takes the first `frames` frames of new configurations. `q(j)`: coordinate j in lanes.
  template <typename Joint>
  void place(int frames, const Joint& q) {
    if (++memory_.epoch == 0) {  // once in 2³² calls
      for (std::size_t i = 0; i < robot_.balls.size(); ++i) tables_.known[i] = 0;
      memory_.epoch = 1;
    }
    for (int i = 0; i < frames; ++i) {
      const KernelFrame& frame = robot_.frames[i];
      const V position = q(frame.coordinate);
      place_frame(i, frame.follows ? position * frame.multiplier + frame.offset : position);
    }
  }

  /// Centre of a ball in O, computed at its first use.
  const Vec& centre(int ball, int frame) {
    Vec& centre = tables_.centres[ball];
    if (tables_.known[ball] != memory_.epoch) {
      tables_.known[ball] = memory_.epoch;
      const float* p = robot_.balls[ball].centre.data();
      centre = frame < 0 ? constant(p) : placed(tables_.frames[frame], p);
    }
    return centre;
  }

  /// Squared distance of p from the obstacle's core [m²].
  [[nodiscard]] V distance2(const KernelObstacle& o, const Vec& p) const { return distance2_of<kWay>(o, p); }
  /// The same of the configurations alone.
  [[nodiscard]] V distance2_at(const KernelObstacle& o, const Vec& p) const { return distance2_of<false>(o, p); }

  /// p in the frame of the obstacle.
  [[nodiscard]] static Vec seen_from(const KernelObstacle& o, const Vec& p) {
    return {along(p, &o.axes[0]) - o.along[0], along(p, &o.axes[3]) - o.along[1], along(p, &o.axes[6]) - o.along[2]};
  }
  /// Those of `lanes` in which a point of the cloud is nearer than `reach` to p, which is in the cloud's frame. Boxes
  /// around points smaller than `coarse` count as near with their points. kOnWay: to the way of each lane. May return
  /// with one lane if that is enough.
  template <bool kOnWay>
  [[nodiscard]] static Bits near_points(const KernelObstacle& o, const Vec& p, float reach, Bits lanes, float coarse,
                                        bool one_is_enough) {
    float extreme[8];
    extremes(p.x, p.y, p.z, extreme);
    const V low_x = all(extreme[0] - reach), high_x = all(reach - extreme[4]);
    const V low_y = all(extreme[1] - reach), high_y = all(reach - extreme[5]);
    const V low_z = all(extreme[2] - reach), high_z = all(reach - extreme[6]);
    const V reach2 = all(reach * reach);
    const float coarse2 = coarse * coarse;
    Bits found = 0;
    int open[kMostOpenNodes];
    int count = 0;
    open[count++] = 0;
    while (count > 0) {
      const world::PointNode& node = o.nodes[open[--count]];
      for (int first = 0; first < node.count; first += kFloats) {
        const auto low = [&](int axis) { return load(node.low[axis] + first); };
        const auto high = [&](int axis) { return load(node.high[axis] + first); };
        const V over_x = max(low(0) - high_x, low_x - high(0));
        const V over_y = max(low(1) - high_y, low_y - high(1));
        const V over_z = max(low(2) - high_z, low_z - high(2));
        Bits met = below(max(over_x, max(over_y, over_z)), V{});
        for (; met != 0; met &= met - 1) {
          const int k = first + __builtin_ctz(met);
          const Bits near = below(gap2<kOnWay>(node, k, p), reach2) & lanes & ~found;
          if (near == 0) continue;
          const int child = node.child[k];
          if (diagonal2(node, k) < coarse2) {
            found |= near;
          } else if (child >= 0) {
            if (count == kMostOpenNodes) return lanes;
            open[count++] = child;
            continue;
          } else {
            const world::PointLeaf& leaf = o.leaves[~child];
            for (int i = 0; i < leaf.count; ++i) {
              const Vec d{p.x - leaf.p[0][i], p.y - leaf.p[1][i], p.z - leaf.p[2][i]};
              found |= below(least2_of<kOnWay>(d), reach2) & near;
            }
          }
          if (found == lanes || (one_is_enough && found != 0)) return found;
        }
      }
    }
    return found;
  }

  /// Square of the smallest distance of d from 0.
  [[nodiscard]] static V least2(const Vec& d) { return least2_of<kWay>(d); }
  template <bool kOnWay>
  [[nodiscard]] static V least2_of(const Vec& d) {
    if constexpr (kOnWay) {
      const Vec way = next_lane(d) - d;
      const V t = share_of_way(dot(d, way), dot(way, way));
      const Vec nearest{d.x + t * way.x, d.y + t * way.y, d.z + t * way.z};
      return dot(nearest, nearest);
    } else {
      return dot(d, d);
    }
  }

  /// Axis and origin of a link in one lane: four columns.
  void lane_frame(int frame, int lane, float* out) const {
    if (frame < 0) {
      for (int i = 0; i < 12; ++i) out[i] = i == 0 || i == 4 || i == 8 ? 1.0F : 0.0F;
      return;
    }
    const Frame& f = tables_.frames[frame];
    const Vec* columns[] = {&f.x, &f.y, &f.z, &f.p};
    for (int i = 0; i < 4; ++i) {
      out[3 * i] = columns[i]->x[lane];
      out[3 * i + 1] = columns[i]->y[lane];
      out[3 * i + 2] = columns[i]->z[lane];
    }
  }

 protected:
  const KernelRobot& robot_;
  const KernelWorld& world_;
  KernelMemory& memory_;
  Tables tables_;

 private:
  /// The share of the way at which it comes nearest to 0, from d · way and way · way. Not exact: any share gives a
  /// distance that is at most a rounding error too large, because the distance is flat around its minimum.
  static V share_of_way(V along, V length2) { return clamp(-along / max(length2, all(1e-20F)), V{}, all(1.0F)); }

  void place_frame(int i, V q) {
    const KernelFrame& frame = robot_.frames[i];
    const float* r = frame.rotation.data();
    Frame& out = tables_.frames[i];
    Vec x, y;
    if (frame.parent < 0) {
      x = constant(r);
      y = constant(r + 3);
      out.z = constant(r + 6);
      out.p = constant(frame.translation.data());
    } else {
      const Frame& parent = tables_.frames[frame.parent];
      const auto column = [&](int k) {
        const int axis = frame.axis[k];
        if (axis < 0) return turned(parent, r + 3 * k);
        const Vec& v = parent.axis(axis);
        return r[3 * k + axis] < 0.0F ? Vec{-v.x, -v.y, -v.z} : v;
      };
      x = column(0);
      y = column(1);
      out.z = column(2);
      out.p = parent.p;
      for (int k = 0; k < 3; ++k) {
        const float t = frame.translation[k];
        if (t == 0.0F) continue;
        const Vec& v = parent.axis(k);
        out.p = {out.p.x + t * v.x, out.p.y + t * v.y, out.p.z + t * v.z};
      }
    }
    if (frame.prismatic) {
      out.x = x;
      out.y = y;
      out.p = {out.p.x + q * out.z.x, out.p.y + q * out.z.y, out.p.z + q * out.z.z};
      return;
    }
    V s, c;
    sine_cosine(q, s, c);
    out.x = {x.x * c + y.x * s, x.y * c + y.y * s, x.z * c + y.z * s};
    out.y = {y.x * c - x.x * s, y.y * c - x.y * s, y.z * c - x.z * s};
  }

  /// Distance of a coordinate from 0: on a way between two values of one sign, that of the smaller one.
  template <bool kOnWay>
  static V away(V x) {
    if constexpr (kOnWay) {
      const V next = next_lane(x);
      return max(min(x, next), -max(x, next));
    } else {
      return abs(x);
    }
  }
  /// Lower bound of the squared distance from the box of a node's child.
  template <bool kOnWay>
  static V gap2(const world::PointNode& node, int k, const Vec& p) {
    const V zero{};
    const auto gap = [&](V x, int axis) {
      if constexpr (kOnWay) {
        const V next = next_lane(x);
        return max(max(node.low[axis][k] - max(x, next), min(x, next) - node.high[axis][k]), zero);
      } else {
        return max(max(node.low[axis][k] - x, x - node.high[axis][k]), zero);
      }
    };
    const V x = gap(p.x, 0);
    const V y = gap(p.y, 1);
    const V z = gap(p.z, 2);
    return x * x + (y * y + z * z);
  }
  static float diagonal2(const world::PointNode& node, int k) {
    float sum = 0.0F;
    for (int axis = 0; axis < 3; ++axis) {
      const float size = node.high[axis][k] - node.low[axis][k];
      sum += size * size;
    }
    return sum;
  }
  /// Squared distance from the z axis.
  template <bool kOnWay>
  static V across2(V x, V y) {
    if constexpr (kOnWay) {
      const V dx = next_lane(x) - x;
      const V dy = next_lane(y) - y;
      const V t = share_of_way(x * dx + y * dy, dx * dx + dy * dy);
      x = x + t * dx;
      y = y + t * dy;
    }
    return x * x + y * y;
  }

  // Along each axis of a box, the distance of the way is that of its nearer end, unless the way crosses the box's
  // middle. The squares of these distances add up to a lower bound of the squared distance.
  template <bool kOnWay>
  [[nodiscard]] V distance2_of(const KernelObstacle& o, const Vec& p) const {
    const V zero{};
    switch (o.kind) {
      case ObstacleKind::kBall: {
        const Vec d = p - constant(o.centre.data());
        if constexpr (kOnWay) {
          return least2(d);
        } else {
          return dot(d, d);
        }
      }
      case ObstacleKind::kAlignedBox: {
        const V x = max(away<kOnWay>(p.x - o.centre[0]) - o.half[0], zero);
        const V y = max(away<kOnWay>(p.y - o.centre[1]) - o.half[1], zero);
        const V z = max(away<kOnWay>(p.z - o.centre[2]) - o.half[2], zero);
        return x * x + (y * y + z * z);
      }
      case ObstacleKind::kBox: {
        const V x = max(away<kOnWay>(along(p, &o.axes[0]) - o.along[0]) - o.half[0], zero);
        const V y = max(away<kOnWay>(along(p, &o.axes[3]) - o.along[1]) - o.half[1], zero);
        const V z = max(away<kOnWay>(along(p, &o.axes[6]) - o.along[2]) - o.half[2], zero);
        return x * x + (y * y + z * z);
      }
      case ObstacleKind::kCapsule: {
        const V z = max(away<kOnWay>(along(p, &o.axes[6]) - o.along[2]) - o.half[2], zero);
        return across2<kOnWay>(along(p, &o.axes[0]) - o.along[0], along(p, &o.axes[3]) - o.along[1]) + z * z;
      }
      case ObstacleKind::kCylinder: {
        const V z = max(away<kOnWay>(along(p, &o.axes[6]) - o.along[2]) - o.half[2], zero);
        const V around = across2<kOnWay>(along(p, &o.axes[0]) - o.along[0], along(p, &o.axes[3]) - o.along[1]);
        const V side = max(sqrt(around) - o.half[0], zero);
        return side * side + z * z;
      }
      case ObstacleKind::kPoints:
        break;  // see near_points()
      case ObstacleKind::kConvex: {
        V most = all(0.0F);
        for (int i = o.first; i < o.first + o.count; ++i) {
          const KernelPlane& plane = world_.planes[i];
          V over = along(p, plane.normal.data());
          if constexpr (kOnWay) over = min(over, next_lane(over));
          most = max(most, over - plane.offset);
        }
        // The distance to the farthest plane is a lower bound of that to the polyhedron.
        return most * most;
      }
    }
    return zero;
  }
};

}  // namespace hecaton::planner::global::HECATON_ISA
