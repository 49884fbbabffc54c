#include "planner/global/validity_kernel.hpp"

#include <cmath>

#include "planner/global/lane_checker.hpp"

namespace hecaton::planner::global::HECATON_ISA {
namespace {

/// Undecided pairs of one block; more count as collisions.
constexpr int kMaxUndecided = 256;

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

/// Configurations by themselves.
class StateChecker : public BlockChecker<false> {
 public:
  explicit StateChecker(const KernelScene& scene) : BlockChecker(scene), exact_(scene.exact) {}

  /// `lanes`: those that count.
  template <typename Joint>
  Bits collisions(Bits lanes, bool any_is_enough, const Joint& q) {
    begin(lanes);
    place(static_cast<int>(robot_.frames.size()), q);
    if (any_is_enough && memory_.hit_link >= 0) {
      const Bits hit = hits_at_lanes(memory_.hit_link, memory_.hit_obstacle);
      if (hit != 0) return hit;
    }
    for (const int link : robot_.order) {
      test_world(link, any_is_enough);
      if (decided(any_is_enough)) return hits();
    }
    for (int i = 0; i < static_cast<int>(robot_.link_pairs.size()); ++i) {
      test_link_pair(i, any_is_enough);
      if (decided(any_is_enough)) return hits();
    }
    Bits blocked = hits();
    if (undecided().overflow) return lanes;
    for (int i = 0; i < undecided().count; ++i) {
      const Undecided& item = undecided().items[i];
      for (Bits left = item.lanes & ~blocked; left != 0; left &= left - 1) {
        const int lane = __builtin_ctz(left);
        if (!exactly_free(item, lane)) blocked |= 1U << lane;
        if (any_is_enough && blocked != 0) return blocked;
      }
    }
    return blocked;
  }

 private:
  [[nodiscard]] bool exactly_free(const Undecided& item, int lane) const {
    const bool of_world = item.link_pair < 0;
    if (robot_.bodies[item.a].round) {
      if (of_world ? world_.obstacles[item.b].kind != ObstacleKind::kConvex : robot_.bodies[item.b].round) return false;
    }
    float one[12], two[12];
    lane_frame(robot_.bodies[item.a].frame, lane, one);
    ExactQuestion question;
    question.from_a = one;
    if (of_world) return exact_.from_obstacle(exact_.context, item.a, item.b, question).at_start > item.padding;
    lane_frame(robot_.bodies[item.b].frame, lane, two);
    question.from_b = two;
    return exact_.from_body(exact_.context, item.a, item.b, question).at_start > item.padding;
  }

  const ExactCheck& exact_;
};

/// Ways on which no point moves farther than this are not divided any more; they count as colliding [m].
constexpr float kFinest = 2e-5F;
/// Exact distances are used where points leave their straight ways by less than this [m].
constexpr float kStraight = 1e-3F;
/// Largest number of blocks for one edge; a grazing edge needs fewer.
constexpr int kMaxBlocks = 4096;
/// Undecided pairs of an edge at all levels; more count as a collision.
constexpr int kMaxListed = 4096;
/// Joint space that the first block of an edge covers at most [rad | m].
constexpr float kLongestBlock = 4.0F;
/// Ways that one finer block divides.
constexpr int kWindow = kFloats > 4 ? (kFloats > 8 ? 3 : 2) : 1;
constexpr float kRoundedUp = 1.0F + 2e-5F;

float larger(float a, float b) {
  return a > b ? a : b;
}

/// Proves that an edge is free. Between two configurations of an edge, each point of the robot stays close to the
/// straight way between its two places: its distance from the way is at most h²/8 times the largest second derivative.
/// The straight ways of a ball are tested exactly, enlarged by that distance. What stays undecided is divided.
class EdgeProver : public BlockChecker<true> {
 public:
  EdgeProver(const KernelScene& scene, const KernelEdge& edge) : BlockChecker(scene), exact_(scene.exact), edge_(edge) {
    set_padding(scene.world.padding + edge.clearance);
    measure_joints();
  }

  bool free() {
    const int pieces = static_cast<int>(larger(1.0F, std::ceil(length_ / kLongestBlock)));
    const float piece = 1.0F / static_cast<float>(pieces);
    const float step = piece / static_cast<float>(kFloats - 1);
    int ends[64];
    if (pieces > 64) return false;
    for (int i = 0; i < pieces; ++i) {
      if (!first_block(static_cast<float>(i) * piece, step)) return false;
      ends[i] = listed_;
    }
    if (listed_ == 0) return true;
    sum_levers(robot_.link_levers.data(), robot_.link_stride, speed_, tables_.link_speed);
    for (int i = 0, from = 0; i < pieces; from = ends[i++]) {
      if (!divide(static_cast<float>(i) * piece, step, from, ends[i])) return false;
    }
    return true;
  }

 private:
  static constexpr Bits kWays = kAllLanes >> 1;

  /// Bounds of first and second derivatives along the edge, from those of the joints. A turning joint j adds at most
  /// lever(j) |q̇(j)| to a point's speed, and lever(j) |q̇(j)| (|q̇(j)| + 2 Σ |q̇(i)|) to its second derivative, i over
  /// the turning joints before it.
  void measure_joints() {
    float speed_of[kMaxDimensions];   // by coordinate
    float second_of[kMaxDimensions];  // its second derivative
    float length2 = 0.0F;
    for (int j = 0; j < robot_.dimensions; ++j) {
      if (edge_.corner == nullptr) {
        speed_of[j] = kRoundedUp * std::fabs(edge_.b[j] - edge_.a[j]);
        second_of[j] = 0.0F;
      } else {
        const float in = edge_.corner[j] - edge_.a[j];
        const float out = edge_.b[j] - edge_.corner[j];
        speed_of[j] = 2.0F * kRoundedUp * larger(std::fabs(in), std::fabs(out));
        second_of[j] = 2.0F * std::fabs(out - in);
      }
      length2 += speed_of[j] * speed_of[j];
    }
    float before = 0.0F;
    for (std::size_t i = 0; i < robot_.frames.size(); ++i) {
      const KernelFrame& frame = robot_.frames[i];
      if (frame.parent < 0) before = 0.0F;
      const float share = std::fabs(frame.multiplier);
      const float speed = share * speed_of[frame.coordinate];
      const float turn = frame.prismatic ? 0.0F : speed;
      tables_.before[i] = before;
      speed_[i] = speed;
      bend_[i] = 0.125F * kRoundedUp * (speed * (turn + 2.0F * before) + share * second_of[frame.coordinate]);
      if (edge_.spread != nullptr) spread_[i] = share * edge_.spread[frame.coordinate];
      before += turn;
    }
    length_ = std::sqrt(length2);
    const float* levers = robot_.link_levers.data();
    sum_levers(levers, robot_.link_stride, bend_, tables_.link_bend);
    sum_levers(levers, robot_.link_stride, spreads(), tables_.link_beyond);
  }
  /// The same of the motion of two links relative to each other.
  void measure_pairs() {
    const float* levers = robot_.pair_levers.data();
    sum_levers(levers, robot_.pair_stride, speed_, tables_.pair_speed);
    sum_levers(levers, robot_.pair_stride, bend_, tables_.pair_bend);
    sum_levers(levers, robot_.pair_stride, spreads(), tables_.pair_beyond);
    for (std::size_t i = 0; i < robot_.link_pairs.size(); ++i) {
      const KernelLinkPair& pair = robot_.link_pairs[i];
      if (!pair.chain) continue;
      // Only the joints between the two count, also before one of them. Less what rounding may have added.
      const float known = tables_.pair_bend[i];
      const float beyond = 0.25F * tables_.before[pair.between] * tables_.pair_speed[i];
      tables_.pair_bend[i] = (known > beyond ? known - beyond : 0.0F) + 1e-5F * known;
    }
    pairs_measured_ = true;
  }
  [[nodiscard]] const float* spreads() const { return edge_.spread == nullptr ? nullptr : spread_; }
  /// `factors` by frame; null: zeros.
  void sum_levers(const float* levers, int stride, const float* factors, float* sums) const {
    for (int i = 0; i < stride; i += kFloats) {
      V sum{};
      if (factors != nullptr) {
        const float* row = levers + i;
        for (std::size_t j = 0; j < robot_.frames.size(); ++j, row += stride) sum = sum + load(row) * factors[j];
      }
      store(sums + i, sum);
    }
  }

  /// Takes the first `frames` frames at t = from + lane · step.
  void place_at(float from, float step, int frames) {
    const V t = from + lane_numbers() * step;
    const V s = 1.0F - t;
    if (edge_.corner == nullptr) {
      place(frames, [&](int j) { return s * edge_.a[j] + t * edge_.b[j]; });
    } else {
      const V w = 2.0F * s * t;
      place(frames, [&](int j) { return s * s * edge_.a[j] + w * edge_.corner[j] + t * t * edge_.b[j]; });
    }
    ++blocks_;
  }

  /// Tests everything; undecided pairs are listed. False if something collides.
  bool first_block(float from, float step) {
    begin(kAllLanes, step);
    place_at(from, step, static_cast<int>(robot_.frames.size()));
    if (memory_.hit_link >= 0 && hits_at_lanes(memory_.hit_link, memory_.hit_obstacle)) return false;
    for (const int link : robot_.order) {
      test_world(link, true);
      if (hits() != 0) return false;
    }
    if (!pairs_measured_) measure_pairs();
    for (int i = 0; i < static_cast<int>(robot_.link_pairs.size()); ++i) {
      test_link_pair(i, true);
      if (hits() != 0) return false;
    }
    return list_undecided();
  }

  /// Takes the undecided pairs of the present block, less those that exact distances decide. False if one collides or
  /// if there are too many.
  bool list_undecided() {
    if (undecided().overflow) return false;
    for (int i = 0; i < undecided().count; ++i) {
      Undecided item = undecided().items[i];
      item.lanes &= kWays;
      if (item.lanes == 0) continue;
      if (!decide_exactly(item)) return false;
      if (item.lanes == 0) continue;
      if (listed_ == kMaxListed) return false;
      list_[listed_++] = item;
    }
    return true;
  }

  /// Removes lanes whose ways are free. False if a lane collides.
  bool decide_exactly(Undecided& item) {
    const bool of_world = item.link_pair < 0;
    const float grown = of_world ? growth(robot_.bodies[item.a].link) : pair_growth(item.link_pair);
    const float beyond =
        of_world ? tables_.link_beyond[robot_.bodies[item.a].link] : tables_.pair_beyond[item.link_pair];
    if (grown - beyond > kStraight) return true;
    if (robot_.bodies[item.a].round) {
      if (of_world ? world_.obstacles[item.b].kind != ObstacleKind::kConvex : robot_.bodies[item.b].round) return true;
    }
    float from_a[12], to_a[12], from_b[12], to_b[12];
    ExactQuestion question;
    question.from_a = from_a;
    question.to_a = to_a;
    question.enough = item.padding + grown;
    if (!of_world) {
      question.from_b = from_b;
      question.to_b = to_b;
      question.seen_from_a = robot_.link_pairs[item.link_pair].chain;
    }
    for (Bits left = item.lanes; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      lane_frame(robot_.bodies[item.a].frame, lane, from_a);
      lane_frame(robot_.bodies[item.a].frame, lane + 1, to_a);
      ExactGap gap;
      if (of_world) {
        gap = exact_.from_obstacle(exact_.context, item.a, item.b, question);
      } else {
        lane_frame(robot_.bodies[item.b].frame, lane, from_b);
        lane_frame(robot_.bodies[item.b].frame, lane + 1, to_b);
        gap = exact_.from_body(exact_.context, item.a, item.b, question);
      }
      if (gap.at_start <= item.padding) return false;
      if (gap.on_way > item.padding + grown) item.lanes &= ~(1U << lane);
    }
    return true;
  }

  /// Divides the ways of the listed pairs [first, last) of the block that begins at `from`.
  bool divide(float from, float step, int first, int last) {
    Bits lanes = 0;
    for (int i = first; i < last; ++i) lanes |= list_[i].lanes;
    while (lanes != 0) {
      const int lane = __builtin_ctz(lanes);
      int end = lane + 1;
      while (end < lane + kWindow && (lanes >> end & 1U) != 0) ++end;
      const Bits window = ((1U << end) - 1U) & ~((1U << lane) - 1U);
      const float finer = step * static_cast<float>(end - lane) / static_cast<float>(kFloats - 1);
      const float start = from + static_cast<float>(lane) * step;
      const int kept = listed_;
      if (!finer_block(start, finer, first, last, window)) return false;
      if (listed_ > kept && !divide(start, finer, kept, listed_)) return false;
      listed_ = kept;
      lanes &= ~window;
    }
    return true;
  }

  bool finer_block(float from, float step, int first, int last, Bits window) {
    if (blocks_ >= kMaxBlocks) return false;
    int frames = 0;
    for (int i = first; i < last; ++i) {
      if ((list_[i].lanes & window) == 0) continue;
      const Undecided& item = list_[i];
      const bool of_world = item.link_pair < 0;
      const float speed =
          of_world ? tables_.link_speed[robot_.bodies[item.a].link] : tables_.pair_speed[item.link_pair];
      if (speed * step < kFinest) return false;
      frames = std::max(frames, robot_.bodies[item.a].frame + 1);
      if (!of_world) frames = std::max(frames, robot_.bodies[item.b].frame + 1);
    }
    begin(kAllLanes, step);
    place_at(from, step, frames);
    for (int i = first; i < last; ++i) {
      const Undecided item = list_[i];
      if ((item.lanes & window) == 0) continue;
      if (item.link_pair < 0) {
        test_balls(robot_.bodies[item.a].ball, robot_.bodies[item.a].link, item.b, true);
      } else {
        test_body_pair(item.link_pair, item.a, item.b, item.padding, true);
      }
      if (hits() != 0) return false;
    }
    return list_undecided();
  }

  const ExactCheck& exact_;
  const KernelEdge& edge_;
  float speed_[kMaxFrames];   ///< by frame: the largest, in units of the edge
  float bend_[kMaxFrames];    ///< by frame: an eighth of what its lever adds to the second derivative
  float spread_[kMaxFrames];  ///< by frame, unless the edge has none
  bool pairs_measured_ = false;
  float length_ = 0.0F;
  int blocks_ = 0;
  int listed_ = 0;
  Undecided list_[kMaxListed];
};

std::size_t floats_needed(const KernelRobot& robot) {
  return Tables::floats_needed(robot);
}

unsigned collisions(const KernelScene& scene, const float* q, int stride) {
  unsigned result = 0;
  for (int first = 0; first < kWidth; first += kFloats) {
    const int count = kWidth - first < kFloats ? kWidth - first : kFloats;
    StateChecker checker(scene);
    result |= checker.collisions((1U << count) - 1U, false, [&](int j) {
      V lanes;
      for (int lane = 0; lane < kFloats; ++lane) {
        lanes[lane] = q[(first + lane % count) * stride + j];
      }
      return lanes;
    }) << first;
  }
  return result;
}

bool edge_sampled(const KernelScene& scene, const KernelEdge& edge, int steps) {
  const int blocks = (steps + kFloats - 1) / kFloats;
  const V lane_start = (lane_numbers() + 1.0F) * static_cast<float>(blocks);
  const float step = 1.0F / static_cast<float>(blocks * kFloats);
  StateChecker checker(scene);
  checker.set_padding(scene.world.padding + edge.clearance);
  // Each block spreads over the whole edge, so that an obstacle is found early.
  for (int block = 0; block < blocks; ++block) {
    const V t = (lane_start - static_cast<float>(block)) * step;
    const V s = 1.0F - t;
    if (checker.collisions(kAllLanes, true, [&](int j) { return s * edge.a[j] + t * edge.b[j]; }) != 0) return false;
  }
  return true;
}

bool edge_proven(const KernelScene& scene, const KernelEdge& edge) {
  return EdgeProver(scene, edge).free();
}

}  // namespace

extern const ValidityKernel kValidity{kFloats, floats_needed, collisions, edge_sampled, edge_proven};

}  // namespace hecaton::planner::global::HECATON_ISA
