#pragma once
/// Which program computed a set-point.

#include <string>

namespace hecaton::services {

/// Version and instructions of the processor on which the results of mathematical functions may depend: "0.9.0 avx2
/// fma". Two programs with one text give the same set-points, bit by bit.
[[nodiscard]] std::string program_text();

}  // namespace hecaton::services
