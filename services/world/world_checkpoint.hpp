#pragma once
/// What a world writes down of itself, so that its successor goes on where it died.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/config/cell_file.hpp"
#include "services/messages/convert.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/turn_watch.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// Cell and stamp are left to the caller.
[[nodiscard]] msg::WorldMemory memory_of(const world::BulletWorld& world);

/// Where a world goes on.
struct Continuation {
  world::Scene scene;
  double time = 0.0;          ///< of the world [s]
  std::int64_t stamp_ns = 0;  ///< when that was, on this host's steady clock
  std::uint64_t edition = 0;
  world::RefereeMemory account;
};
/// `scene`: of the cell file, for all but the obstacles.
messages::Converted<Continuation> continuation(const msg::WorldMemory& memory, const world::Scene& scene);

/// Writes memories from a thread of its own: the world's loop never waits for a disk. When memories come faster than
/// they can be written only the newest counts. What cannot be written leaves the last one that could.
class CheckpointWriter {
 public:
  using Clock = std::chrono::steady_clock;

  /// After this the thread counts as hanging: sooner than clients give up.
  static constexpr std::chrono::seconds kLongestWrite{1};

  /// An empty path: nothing is kept, and all of it at once.
  explicit CheckpointWriter(std::string path);
  /// Writes what is left.
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  /// The memory's number, from 1.
  std::uint64_t keep(msg::WorldMemory memory);
  struct Outcome {
    bool known = false;                    ///< the file has it or a newer one, or it is known why not
    std::optional<std::string> failure{};  ///< why not, a sentence
  };
  /// What became of the memory of this number.
  [[nodiscard]] Outcome outcome(std::uint64_t number) const;
  /// Why the newest is not in the file, a sentence; empty: it is, or that is not known yet.
  [[nodiscard]] std::optional<std::string> failure() const;
  /// Every turn of the loop: notes for how long the thread has not answered.
  void look(Clock::time_point now);

 private:
  void write();
  [[nodiscard]] std::optional<std::string> silence() const;

  std::string path_;
  TurnWatch watch_;  ///< of the loop alone
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<msg::WorldMemory> next_;
  std::uint64_t given_ = 0;
  std::uint64_t tried_ = 0;
  std::uint64_t kept_ = 0;
  std::optional<std::string> failure_;  ///< of the last that was tried
  bool ending_ = false;
  std::thread writer_;
};

/// The world's checkpoint file: what an earlier world left there, and what this one writes.
class WorldPersistence {
 public:
  /// An empty path: nothing is kept. A file that is there and cannot be used stays as it is.
  WorldPersistence(const config::CellFile& file, const std::string& path);

  /// The scene of the world that died; that of the cell file where there was none.
  [[nodiscard]] const world::Scene& scene(const config::CellFile& file) const {
    return before_ ? before_->scene : file.cell.scene;
  }
  /// Why what was edited before cannot be recovered, a sentence; empty: it can, or there was nothing.
  [[nodiscard]] const std::optional<std::string>& lost() const { return lost_; }
  /// `world`: of scene(), before its first step. Brings it to the time, edition and contacts of the world that died;
  /// returns its number of contacts, or nothing when there was none.
  std::optional<std::uint64_t> go_on(world::BulletWorld& world);

  /// The number of what is to be written, see CheckpointWriter.
  std::uint64_t write(const world::BulletWorld& world);
  /// Once in every turn of the loop.
  void look(bus::Clock::time_point now);
  /// Why edits are not persisted, a sentence; empty: they are.
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }
  [[nodiscard]] const CheckpointWriter& writer() const { return writer_; }

 private:
  std::string cell_;
  std::optional<std::string> lost_;
  std::optional<Continuation> before_;
  CheckpointWriter writer_;
  std::optional<std::string> failure_;  ///< as it was logged
};

/// `what`: "the edit is "; `why`: as of CheckpointWriter.
[[nodiscard]] msg::Cause not_persisted(const std::string& what, const std::string& why);

}  // namespace hecaton::services
