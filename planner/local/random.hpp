#pragma once
/// Random numbers as a value of eight bytes, so that a tick's memory can hold the generator. Equal on every machine.

#include <cmath>
#include <cstdint>
#include <numbers>

#include "planner/model/memory_archive.hpp"

namespace hecaton::planner {

/// SplitMix64 [Steele14].
class Random {
 public:
  explicit Random(std::uint64_t seed = 0) : state_(seed) {}  ///< equal seeds give equal numbers

  /// 64 random bits.
  std::uint64_t next() {
    state_ += 0x9E37'79B9'7F4A'7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58'476D'1CE4'E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D0'49BB'1331'11EBULL;
    return z ^ (z >> 31);
  }

  /// In [0, 1).
  double uniform() { return static_cast<double>(next() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }  ///< in [low, high)

  /// Standard normal (Box–Muller, one of the pair).
  double normal() {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
    return radius * std::cos(2.0 * std::numbers::pi * uniform());
  }

  void describe(MemoryArchive& archive) { archive(state_); }

 private:
  std::uint64_t state_;
};

}  // namespace hecaton::planner
