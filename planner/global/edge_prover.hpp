#pragma once
/// Part of the collision kernel, compiled once per instruction set: the proof that an edge is
/// free. Included by validity_kernel.cpp only, so that all of it may be inlined there.

#include <cmath>

#include "planner/global/block_checker.hpp"

namespace hecaton::planner::global::HECATON_ISA {
namespace {

/// Ways on which no point moves farther than this are not divided any more; they count as colliding [m].
inline constexpr float kFinest = 2e-5F;
/// Exact distances are used where points leave their straight ways by less than this [m].
inline constexpr float kStraight = 1e-3F;
/// Largest number of blocks for one edge; a grazing edge needs fewer.
inline constexpr int kMaxBlocks = 4096;
/// Undecided pairs of an edge at all levels; more count as a collision.
inline constexpr int kMaxListed = 4096;
/// Joint space that the first block of an edge covers at most [rad | m].
inline constexpr float kLongestBlock = 4.0F;
/// Ways that one finer block divides.
inline constexpr int kWindow = kFloats > 4 ? (kFloats > 8 ? 3 : 2) : 1;
inline constexpr float kRoundedUp = 1.0F + 2e-5F;

inline float larger(float a, float b) {
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
  /// lever(j) |q̇(j)| to a point's speed. To its second derivative it adds at most lever(j) |q̇(j)| (|q̇(j)| + 2 Σ
  /// |q̇(i)|), i over the turning joints before it.
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

}  // namespace
}  // namespace hecaton::planner::global::HECATON_ISA
