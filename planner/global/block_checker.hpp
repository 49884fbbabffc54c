#pragma once
/// Part of the collision kernel, compiled once per instruction set: tests of links and pairs of links in one
/// block of lanes. Included by validity_kernel.cpp only, so that all of it may be inlined there.

#include "planner/global/lane_checker.hpp"

namespace hecaton::planner::global::HECATON_ISA {
namespace {

/// Undecided pairs of one block; more count as collisions.
inline constexpr int kMaxUndecided = 256;

/// A pair that balls do not decide. Without initial values, because lists of it are long and hardly used.
struct Undecided {
  int a;          ///< a body
  int b;          ///< a body or an obstacle
  int link_pair;  ///< −1: an obstacle
  float padding;  ///< distance to keep [m]
  Bits lanes;
};

struct UndecidedList {
  Undecided items[kMaxUndecided];
  int count = 0;
  bool overflow = false;

  void add(const Undecided& item) {
    if (count > 0) {
      Undecided& last = items[count - 1];
      if (last.a == item.a && last.b == item.b && last.link_pair == item.link_pair) {
        last.lanes |= item.lanes;
        return;
      }
    }
    if (count == kMaxUndecided) {
      overflow = true;
      return;
    }
    items[count++] = item;
  }
};

/// Tests of links and pairs of links in one block of lanes. If the covering balls are clear, so is the shape. If a ball
/// inside the shape collides, so does the shape. Other pairs are collected.
template <bool kWay>
class BlockChecker : public LaneChecker<kWay> {
  using Base = LaneChecker<kWay>;

 protected:
  using Base::memory_;
  using Base::robot_;
  using Base::tables_;
  using Base::world_;

 public:
  explicit BlockChecker(const KernelScene& scene) : Base(scene), padding_(scene.world.padding) {}

  /// Forgets what was found. `lanes`: the lanes that count. `step`: from each lane to the next, in units of the edge.
  void begin(Bits lanes, float step = 0.0F) {
    lanes_ = lanes;
    step_ = step;
    hits_ = 0;
    undecided_.count = 0;
    undecided_.overflow = false;
  }
  void set_padding(float padding) { padding_ = padding; }

  /// Lanes whose configurations collide.
  [[nodiscard]] Bits hits() const { return hits_; }
  [[nodiscard]] UndecidedList& undecided() { return undecided_; }

  /// How far a link may be from where the lanes say [m].
  [[nodiscard]] float growth(int link) const {
    if constexpr (kWay) {
      return tables_.link_bend[link] * step_ * step_ + tables_.link_beyond[link];
    } else {
      return 0.0F;
    }
  }
  [[nodiscard]] float beyond(int link) const {
    if constexpr (kWay) {
      return tables_.link_beyond[link];
    } else {
      return 0.0F;
    }
  }
  [[nodiscard]] float pair_growth(int pair) const {
    if constexpr (kWay) {
      return tables_.pair_bend[pair] * step_ * step_ + tables_.pair_beyond[pair];
    } else {
      return 0.0F;
    }
  }

  /// Tests a link with each obstacle whose box meets that of the link in all lanes. Returns at the first hit if
  /// `any_is_enough`.
  void test_world(int index, bool any_is_enough) {
    const KernelLink& link = robot_.links[index];
    const float around = padding_ + growth(index);
    const float reach = robot_.balls[link.ball].radius + around;
    const Vec& p = this->centre(link.ball, link.frame);
    float extreme[8];
    extremes(p.x, p.y, p.z, extreme);
    const V low_x = all(extreme[0] - reach), high_x = all(reach - extreme[4]);
    const V low_y = all(extreme[1] - reach), high_y = all(reach - extreme[5]);
    const V low_z = all(extreme[2] - reach), high_z = all(reach - extreme[6]);
    const bool all_obstacles = padding_ + beyond(index) > world_.padding + world_.margin;
    const KernelBoxes* boxes = all_obstacles ? world_.all.data() : world_.boxes.data() + world_.boxes_of_link[index];
    const KernelBoxes* end =
        all_obstacles ? boxes + world_.all.size() : world_.boxes.data() + world_.boxes_of_link[index + 1];
    for (; boxes != end; ++boxes) {
      for (int first = 0; first < kTablePadding; first += kFloats) {
        const auto low = [&](int k) { return load(boxes->low[k].data() + first); };
        const auto high = [&](int k) { return load(boxes->high[k].data() + first); };
        const V over_x = max(low(0) - high_x, low_x - high(0));
        const V over_y = max(low(1) - high_y, low_y - high(1));
        const V over_z = max(low(2) - high_z, low_z - high(2));
        Bits near = below(max(over_x, max(over_y, over_z)), V{});
        for (; near != 0; near &= near - 1) {
          test_balls(link.ball, index, boxes->obstacle[first + __builtin_ctz(near)], any_is_enough);
          if (decided(any_is_enough)) return;
        }
      }
    }
  }

  /// Lanes whose configurations surely collide at this link and obstacle. Finds nothing else.
  Bits hits_at_lanes(int index, int obstacle) {
    const KernelLink& link = robot_.links[index];
    const KernelObstacle& met = world_.obstacles[obstacle];
    const int end = robot_.balls[link.ball].next;
    if (met.kind == ObstacleKind::kPoints) return hits_of_cloud_at_lanes(link, met);
    for (int i = link.ball; i < end;) {
      const KernelBall& ball = robot_.balls[i];
      const V distance2 = this->distance2_at(met, this->centre(i, link.frame));
      if (ball.inner > 0.0F) {
        const float inner = inner_reach(ball, met);
        const Bits sure = below(distance2, all(inner * inner)) & lanes_;
        if (sure != 0) return sure;
      }
      const float reach = ball.radius + met.radius;
      i = (below(distance2, all(reach * reach)) & lanes_) != 0 ? i + 1 : ball.next;
    }
    return 0;
  }

  /// Tests the balls of a subtree of a link with an obstacle.
  void test_balls(int root, int index, int obstacle, bool any_is_enough) {
    const KernelObstacle& met = world_.obstacles[obstacle];
    if (met.kind == ObstacleKind::kPoints) {
      test_cloud(root, index, obstacle, any_is_enough);
      return;
    }
    const int frame = robot_.links[index].frame;
    const float around = padding_ + growth(index) + met.radius;
    const int end = robot_.balls[root].next;
    for (int i = root; i < end;) {
      const KernelBall& ball = robot_.balls[i];
      const Vec& p = this->centre(i, frame);
      const V distance2 = this->distance2(met, p);
      const float reach = ball.radius + around;
      const Bits near = below(distance2, all(reach * reach)) & lanes_ & ~hits_;
      if (near == 0) {
        i = ball.next;
        continue;
      }
      Bits sure = 0;
      if (ball.inner > 0.0F) {
        const float inner = inner_reach(ball, met);
        const V at = kWay ? this->distance2_at(met, p) : distance2;
        sure = below(at, all(inner * inner)) & near;
        if (sure != 0) {
          hits_ |= sure;
          memory_.hit_link = index;
          memory_.hit_obstacle = obstacle;
          if (any_is_enough) return;
        }
      }
      if (ball.next == i + 1 && (near & ~sure) != 0) {
        undecided_.add({robot_.body_of_ball[i], obstacle, -1, padding_, near & ~sure});
      }
      ++i;
    }
  }

  void test_link_pair(int index, bool any_is_enough) {
    const KernelLinkPair& pair = robot_.link_pairs[index];
    const KernelBall& one = robot_.balls[robot_.links[pair.a].ball];
    const KernelBall& two = robot_.balls[robot_.links[pair.b].ball];
    const Vec d = this->centre(robot_.links[pair.a].ball, robot_.links[pair.a].frame) -
                  this->centre(robot_.links[pair.b].ball, robot_.links[pair.b].frame);
    float reach = one.radius + two.radius + pair.padding;
    if constexpr (kWay) reach += 0.5F * step_ * tables_.pair_speed[index] + tables_.pair_beyond[index];
    if ((below(dot(d, d), all(reach * reach)) & ~hits_) == 0) return;
    begin_pair();
    const float around = pair.padding + pair_growth(index);
    const int last = pair.first + pair.count;
    for (int i = pair.first; i < last;) {
      const int a = robot_.pairs[i].a;
      const bool near = pair.count < 3 || meets(pair, robot_.bodies[a].ball, robot_.links[pair.b].ball, around) != 0;
      for (; i < last && robot_.pairs[i].a == a; ++i) {
        if (!near) continue;
        test_bodies(index, a, robot_.pairs[i].b, robot_.pairs[i].padding, any_is_enough);
        if (decided(any_is_enough)) return;
      }
    }
  }

  /// The same for one pair of bodies of the link pair.
  void test_body_pair(int index, int a, int b, float padding, bool any_is_enough) {
    begin_pair();
    test_bodies(index, a, b, padding, any_is_enough);
  }

  [[nodiscard]] bool decided(bool any_is_enough) const {
    return hits_ != 0 && (any_is_enough || (hits_ & lanes_) == lanes_);
  }

 private:
  /// For the balls above the leaves, boxes around points are as good as the points if they are smaller than this share
  /// of the ball.
  static constexpr float kCoarse = 0.5F;

  static bool is_leaf(const KernelBall& ball, int index) { return ball.next == index + 1; }
  static float coarse(const KernelBall& ball, int index) { return is_leaf(ball, index) ? 0.0F : kCoarse * ball.radius; }

  Bits hits_of_cloud_at_lanes(const KernelLink& link, const KernelObstacle& met) {
    const int end = robot_.balls[link.ball].next;
    for (int i = link.ball; i < end;) {
      const KernelBall& ball = robot_.balls[i];
      const Vec p = this->seen_from(met, this->centre(i, link.frame));
      if (ball.inner > 0.0F) {
        const Bits sure = this->template near_points<false>(met, p, inner_reach(ball, met), lanes_, 0.0F, true);
        if (sure != 0) return sure;
      }
      const bool below_it = is_leaf(ball, i) || this->template near_points<false>(met, p, ball.radius + met.radius,
                                                                                  lanes_, coarse(ball, i), true) != 0;
      i = below_it ? i + 1 : ball.next;
    }
    return 0;
  }

  /// test_balls() for a cloud of points.
  void test_cloud(int root, int index, int obstacle, bool any_is_enough) {
    const KernelObstacle& met = world_.obstacles[obstacle];
    const int frame = robot_.links[index].frame;
    const float around = padding_ + growth(index) + met.radius;
    const int end = robot_.balls[root].next;
    for (int i = root; i < end;) {
      const KernelBall& ball = robot_.balls[i];
      const Vec p = this->seen_from(met, this->centre(i, frame));
      const Bits near =
          this->template near_points<kWay>(met, p, ball.radius + around, lanes_ & ~hits_, coarse(ball, i), false);
      if (near == 0) {
        i = ball.next;
        continue;
      }
      Bits sure = 0;
      if (ball.inner > 0.0F) {
        sure = this->template near_points<false>(met, p, inner_reach(ball, met), near, 0.0F, any_is_enough);
        if (sure != 0) {
          hits_ |= sure;
          memory_.hit_link = index;
          memory_.hit_obstacle = obstacle;
          if (any_is_enough) return;
        }
      }
      if (is_leaf(ball, i) && (near & ~sure) != 0) {
        undecided_.add({robot_.body_of_ball[i], obstacle, -1, padding_, near & ~sure});
      }
      ++i;
    }
  }

  /// A centre nearer to the obstacle's core than this surely collides. The distance from a convex obstacle is a lower
  /// bound: only a centre inside it, at distance 0, is sure.
  static float inner_reach(const KernelBall& ball, const KernelObstacle& met) {
    return met.kind == ObstacleKind::kConvex ? 1e-6F : ball.inner + met.radius;
  }

  /// Forgets centres seen from another link.
  void begin_pair() {
    if (++memory_.view == 0) {  // once in 2³² calls
      for (std::size_t i = 0; i < robot_.balls.size(); ++i) tables_.viewed[i] = 0;
      memory_.view = 1;
    }
  }

  /// From ball i of link a to ball k of link b; on ways of a chain as link a sees it.
  Vec between(const KernelLinkPair& pair, int i, int k) {
    const int frame_a = robot_.links[pair.a].frame;
    const int frame_b = robot_.links[pair.b].frame;
    if (!kWay || !pair.chain) return this->centre(k, frame_b) - this->centre(i, frame_a);
    return view(k, frame_b, frame_a) - constant(robot_.balls[i].centre.data());
  }
  /// Lanes in which the two balls may come nearer to each other than `around`.
  Bits meets(const KernelLinkPair& pair, int i, int k, float around) {
    const float reach = robot_.balls[i].radius + robot_.balls[k].radius + around;
    return below(this->least2(between(pair, i, k)), all(reach * reach)) & lanes_ & ~hits_;
  }

  void test_bodies(int index, int a, int b, float padding, bool any_is_enough) {
    const KernelLinkPair& pair = robot_.link_pairs[index];
    const float around = padding + pair_growth(index);
    Bits sure = 0;
    const auto meet = [&](int i, int k) {
      const KernelBall& one = robot_.balls[i];
      const KernelBall& two = robot_.balls[k];
      const Vec d = between(pair, i, k);
      const float reach = one.radius + two.radius + around;
      const Bits near = below(this->least2(d), all(reach * reach)) & lanes_ & ~hits_;
      if (near != 0 && one.inner > 0.0F && two.inner > 0.0F) {
        const float inner = one.inner + two.inner;
        sure |= below(dot(d, d), all(inner * inner)) & near;
      }
      return near;
    };
    Bits maybe = 0;
    const int root_b = robot_.bodies[b].ball;
    const int end_b = robot_.balls[root_b].next;
    const int end_a = robot_.balls[robot_.bodies[a].ball].next;
    for (int i = robot_.bodies[a].ball; i < end_a;) {
      const KernelBall& one = robot_.balls[i];
      const Bits near_root = meet(i, root_b);
      if (sure != 0 && any_is_enough) break;
      if (near_root == 0) {
        i = one.next;
        continue;
      }
      if (one.next != i + 1) {
        ++i;
        continue;
      }
      for (int k = root_b; k < end_b;) {
        const KernelBall& two = robot_.balls[k];
        const Bits near = k == root_b ? near_root : meet(i, k);
        if (near != 0 && two.next == k + 1) maybe |= near;
        k = near == 0 ? two.next : k + 1;
      }
      i = one.next;
    }
    hits_ |= sure;
    if ((maybe & ~hits_) != 0) undecided_.add({a, b, index, padding, maybe & ~hits_});
  }

  /// A ball's centre in the frame of link a.
  const Vec& view(int ball, int frame, int frame_a) {
    Vec& seen = tables_.relative[ball];
    if (tables_.viewed[ball] != memory_.view) {
      tables_.viewed[ball] = memory_.view;
      const Vec& p = this->centre(ball, frame);
      seen = frame_a < 0 ? p : seen_from(tables_.frames[frame_a], p);
    }
    return seen;
  }

  float padding_;
  float step_ = 0.0F;
  Bits lanes_ = kAllLanes;
  Bits hits_ = 0;
  UndecidedList undecided_;
};

}  // namespace
}  // namespace hecaton::planner::global::HECATON_ISA
