#pragma once
/// What every program of the project returns.

namespace hecaton::services {

enum class ExitCode : int {
  kDone = 0,
  kNegative = 1,  ///< it ran and the outcome is negative
  kUsage = 2,     ///< the command line was not understood
  kBadInput = 3,  ///< cell, URDF, network, …: one sentence on stderr
  kTimeOut = 4,
  kUnreachable = 5,  ///< no such cell
};

}  // namespace hecaton::services
