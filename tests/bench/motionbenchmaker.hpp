#pragma once
/// The problems of MotionBenchMaker, from a folder that the command line names.

#include <string>

namespace hecaton::bench {

/// Registers the benchmark `motionbenchmaker/FAMILY` for every folder with pairs of sceneNNNN.yaml and
/// requestNNNN.yaml below `problems`, and `motionbenchmaker/all`. Throws when a file cannot be read.
void register_motionbenchmaker(const std::string& urdf, const std::string& srdf, const std::string& problems);

}  // namespace hecaton::bench
