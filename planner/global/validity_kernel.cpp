#include "planner/global/validity_kernel.hpp"

#include "planner/global/block_checker.hpp"
#include "planner/global/edge_prover.hpp"

namespace hecaton::planner::global::HECATON_ISA {
namespace {

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
