#pragma once
/// What every program of the project returns.

namespace hecaton::services {

enum class ExitCode : int {
  kDone = 0,
  kNegative = 1,  ///< it ran and the outcome is negative
  kUsage = 2,     ///< no such command, option or choice, or one too many or too few
  kBadInput = 3,  ///< a value that cannot be (option, file, environment): one sentence on stderr
  kTimeOut = 4,
  kUnreachable = 5,  ///< no such cell
};

}  // namespace hecaton::services
