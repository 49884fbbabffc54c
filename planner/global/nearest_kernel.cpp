#include "planner/global/nearest_kernel.hpp"

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::global::HECATON_ISA {
namespace {

using namespace hecaton::planner::HECATON_ISA;
using V = FloatLanes;

V group_distance2(const float* group, int dimensions, const float* q) {
  V sum{};
  for (int j = 0; j < dimensions; ++j) {
    const V d = load(group + j * kFloatLanes) - q[j];
    sum += d * d;
  }
  return sum;
}

Neighbour nearest(const float* groups, int count, int dimensions, const float* q) {
  V best = all_floats(3e38F);
  FloatMask where{};
  for (int group = 0; group < count; ++group) {
    const V d = group_distance2(groups + static_cast<long>(group) * dimensions * kFloatLanes, dimensions, q);
    const FloatMask better = d < best;
    best = better ? d : best;
    where = better ? FloatMask{} + group : where;
  }
  Neighbour result{-1, 3e38F};
  for (int lane = 0; lane < kFloatLanes; ++lane) {
    const int index = where[lane] * kFloatLanes + lane;
    if (best[lane] < result.distance2 || (best[lane] == result.distance2 && index < result.index)) {
      result = {index, best[lane]};
    }
  }
  return result;
}

void distances2(const float* groups, int count, int dimensions, const float* q, float* out) {
  for (int group = 0; group < count; ++group) {
    store(out + group * kFloatLanes,
          group_distance2(groups + static_cast<long>(group) * dimensions * kFloatLanes, dimensions, q));
  }
}

}  // namespace

extern const NearestKernel kNearest{nearest, distances2};

}  // namespace hecaton::planner::global::HECATON_ISA
