#pragma once
/// Eight configurations at a time against a world and themselves. Compiled once for each instruction set.

#include "planner/global/validity_data.hpp"

namespace hecaton::planner::global {

struct ValidityKernel {
  /// Bit i: configuration i of eight, each `stride` floats after the one before, is in collision.
  unsigned (*collisions)(const KernelRobot&, const KernelWorld&, const ExactCheck&, const float* q, int stride);
  /// True when none of `blocks` times eight configurations, evenly spread over the straight way from a (not itself) to
  /// b (itself), is in collision. Each block is spread over the whole way, so that what is in the way is met early.
  bool (*edge_free)(const KernelRobot&, const KernelWorld&, const ExactCheck&, const float* a, const float* b,
                    int blocks);
  /// Of eight stretches with their middles in these configurations, each `stride` floats after the one before. Gives up
  /// where one collides for sure.
  SweepHits (*swept)(const KernelRobot&, const KernelWorld&, const ExactCheck&, const KernelSweep&, const float* q,
                     int stride);
};

[[nodiscard]] const ValidityKernel& fastest_validity();

namespace baseline {
extern const ValidityKernel kValidity;
}
namespace avx2 {
extern const ValidityKernel kValidity;
}

}  // namespace hecaton::planner::global
