#pragma once
/// Writes the world's memory from a thread of its own: its loop never waits for a disk. When memories come faster than
/// they can be written only the newest counts.

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <idl/world.h>

namespace hecaton::services {

class MemoryKeeper {
 public:
  /// An empty path: nothing is kept, and all of it at once.
  explicit MemoryKeeper(std::string path);
  /// Writes what is left.
  ~MemoryKeeper();
  MemoryKeeper(const MemoryKeeper&) = delete;
  MemoryKeeper& operator=(const MemoryKeeper&) = delete;

  /// The memory's number, from 1.
  std::uint64_t keep(msg::WorldMemory memory);
  /// It (or a newer one) was written, or could not be.
  [[nodiscard]] bool kept(std::uint64_t number) const;
  /// Why the newest could not be written, a sentence; empty: it could.
  [[nodiscard]] std::string failure() const;

 private:
  void write();

  std::string path_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<msg::WorldMemory> next_;
  std::uint64_t given_ = 0;
  std::uint64_t kept_ = 0;
  std::string failure_;
  bool ending_ = false;
  std::thread writer_;
};

}  // namespace hecaton::services
