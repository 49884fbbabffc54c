#pragma once
/// P5: RRT-Connect for a robot loaded at run time on MotionBenchMaker's problems [Chamzas21], beside OMPL and FCL.

namespace hecaton::bench {

/// Runs `hecaton-bench-plan motionbenchmaker`: `words` are its own name and arguments. Returns the exit code.
[[nodiscard]] int run_motionbenchmaker(int count, const char* const* words);

}  // namespace hecaton::bench
