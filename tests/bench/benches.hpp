#pragma once
/// What hecaton-bench measures.

#include "tests/bench/timings.hpp"

namespace hecaton::bench {

/// The whole tick, and where its time goes; against FCL's pairwise distances alone.
void run_tick(Output output);
/// The distance pass alone, against FCL's on the same pairs; what FCL gets wrong goes to stderr.
void run_distance(Output output);
/// Ticks of cells of 3 to 100 arms.
void run_growth(Output output);

/// Cells played forward, as rollouts and simulations do: ticks a second of one core.
void run_plays(Output output);

}  // namespace hecaton::bench
