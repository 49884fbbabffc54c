#pragma once
/// Which terms a process accepts. Private to services/bus; standard library only.

#include <atomic>
#include <chrono>
#include <cstdint>

#include "services/bus/mailbox.hpp"
#include "services/bus/wire_rules.hpp"

namespace hecaton::bus {

/// The first term that a process hears may be an intruder's, and a process that follows it refuses all others as too
/// old. So a process that knows no term takes none above kTermLeap at first. A supervisor publishes its term every 25
/// ms. Thread-safe.
class TermLimit {
 public:
  static constexpr std::chrono::seconds kFirstWait{30};

  explicit TermLimit(Clock::time_point now) : began_(now) {}

  /// The process knows this term from an earlier one. One that is not usable changes nothing.
  void know(std::uint64_t term) {
    if (is_usable_term(term)) raise(term);
  }
  /// False for a term that leaps above every term that was admitted before.
  [[nodiscard]] bool admits(std::uint64_t term, Clock::time_point now) {
    const std::uint64_t known = largest_;
    if (term > known + kTermLeap) {
      const bool waited = known == 0 && now - began_ > kFirstWait;
      if (!waited || term > kLargestFirstTerm) return false;
    }
    raise(term);
    return true;
  }

 private:
  void raise(std::uint64_t term) {
    std::uint64_t known = largest_;
    while (term > known && !largest_.compare_exchange_weak(known, term)) {
    }
  }

  const Clock::time_point began_;
  std::atomic<std::uint64_t> largest_ = 0;  ///< admitted or remembered
};

}  // namespace hecaton::bus
