#pragma once
/// Writes the world's memory from a thread of its own: its loop never waits for a disk. When memories come faster than
/// they can be written only the newest counts. What cannot be written leaves the last one that could.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <idl/world.h>

#include "services/runtime/turn_watch.hpp"

namespace hecaton::services {

class MemoryKeeper {
 public:
  using Clock = std::chrono::steady_clock;

  /// Who waits for a memory is told after this that the thread does not answer: sooner than clients give up.
  static constexpr std::chrono::seconds kLongestWrite{1};

  /// An empty path: nothing is kept, and all of it at once.
  explicit MemoryKeeper(std::string path);
  /// Writes what is left.
  ~MemoryKeeper();
  MemoryKeeper(const MemoryKeeper&) = delete;
  MemoryKeeper& operator=(const MemoryKeeper&) = delete;

  /// The memory's number, from 1.
  std::uint64_t keep(msg::WorldMemory memory);
  /// What became of it: nothing, that is not known yet; empty, it (or a newer one) is kept; otherwise the sentence that
  /// says why not.
  [[nodiscard]] std::optional<std::string> outcome(std::uint64_t number) const;
  /// Why the newest is not kept, a sentence; empty: it is, or that is not known yet.
  [[nodiscard]] std::string failure() const;
  /// Every turn of the loop: notes for how long the thread has not answered.
  void look(Clock::time_point now);

 private:
  void write();
  [[nodiscard]] std::string silence() const;

  std::string path_;
  TurnWatch watch_;  ///< of the loop alone
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<msg::WorldMemory> next_;
  std::uint64_t given_ = 0;
  std::uint64_t tried_ = 0;
  std::uint64_t kept_ = 0;
  std::string failure_;  ///< of the last that was tried
  bool ending_ = false;
  std::thread writer_;
};

}  // namespace hecaton::services
