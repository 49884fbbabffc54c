#pragma once
/// The world's checkpoint: the state with which a restarted world continues.

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
#include "services/runtime/progress_watchdog.hpp"
#include "world/sim/bullet_world.hpp"

namespace hecaton::services {

/// The caller sets cell and stamp.
[[nodiscard]] msg::WorldCheckpoint checkpoint_of(const world::BulletWorld& world);

/// A checkpoint as values.
struct RestoredWorld {
  world::Scene scene;
  double time = 0.0;          ///< of the world [s]
  std::int64_t stamp_ns = 0;  ///< of that instant, on this host's steady clock
  std::uint64_t edition = 0;
  world::ContactCheckpoint contacts;
};
/// `scene`: the cell file's, from which everything but the obstacles is taken.
messages::Converted<RestoredWorld> restored(const msg::WorldCheckpoint& checkpoint, const world::Scene& scene);

/// Writes checkpoints to a file on a thread of its own, so that the world's loop never waits for a disk. When
/// checkpoints come faster than they can be written, only the newest is written. After a failure the file keeps the
/// last good one. All calls are for the loop's thread.
class CheckpointWriter {
 public:
  using Clock = std::chrono::steady_clock;

  /// A longer write counts as a failure. It is shorter than the time-outs of clients.
  static constexpr std::chrono::seconds kLongestWrite{1};

  /// With an empty path it writes nothing and reports success at once.
  explicit CheckpointWriter(std::string path);
  /// Writes the checkpoint that is left.
  ~CheckpointWriter();
  CheckpointWriter(const CheckpointWriter&) = delete;
  CheckpointWriter& operator=(const CheckpointWriter&) = delete;

  /// Hands over a checkpoint and returns its number, from 1.
  std::uint64_t write(msg::WorldCheckpoint checkpoint);
  struct Outcome {
    bool known = false;                    ///< it, or a newer one, is in the file, or its write has failed
    std::optional<std::string> failure{};  ///< a sentence when the write has failed
  };
  /// The outcome of the checkpoint with this number.
  [[nodiscard]] Outcome outcome(std::uint64_t number) const;
  /// A sentence when the newest write has failed.
  [[nodiscard]] std::optional<std::string> failure() const;
  /// Supervises the thread. Call it in each turn of the loop.
  void update(Clock::time_point now);

 private:
  void run();
  [[nodiscard]] std::optional<std::string> silence() const;

  std::string path_;
  ProgressWatchdog watchdog_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::optional<msg::WorldCheckpoint> next_;
  std::uint64_t given_ = 0;             ///< number of the newest checkpoint
  std::uint64_t tried_ = 0;             ///< number of the last one whose write has ended
  std::uint64_t written_ = 0;           ///< number of the one in the file
  std::optional<std::string> failure_;  ///< of the last write
  bool ending_ = false;
  std::thread writer_;
};

/// The world's checkpoint file: the checkpoint of an earlier process, and those of this one. For the loop's thread.
class WorldPersistence {
 public:
  /// An empty path keeps nothing. An unusable file is not overwritten.
  WorldPersistence(const config::CellFile& file, const std::string& path);

  /// The scene of the earlier process, or the cell file's without one.
  [[nodiscard]] const world::Scene& scene(const config::CellFile& file) const {
    return before_ ? before_->scene : file.cell.scene;
  }
  /// A sentence when the earlier process's checkpoint is unusable, so that its edits are lost.
  [[nodiscard]] const std::optional<std::string>& unusable() const { return unusable_; }
  /// Sets time, edition and contacts of `world`, made from scene() and not stepped yet, to those of the earlier
  /// process. Returns the number of its contacts; empty when there was no earlier process.
  std::optional<std::uint64_t> restore(world::BulletWorld& world);

  /// Writes a checkpoint and returns its number, see CheckpointWriter.
  std::uint64_t write(const world::BulletWorld& world);
  /// Supervises the writer and logs its failures. Call it in each turn of the loop.
  void update(bus::Clock::time_point now);
  /// A sentence while edits are not persisted.
  [[nodiscard]] const std::optional<std::string>& failure() const { return failure_; }
  [[nodiscard]] const CheckpointWriter& writer() const { return writer_; }

 private:
  std::string cell_;
  std::optional<std::string> unusable_;
  std::optional<RestoredWorld> before_;
  CheckpointWriter writer_;
  std::optional<std::string> failure_;  ///< the logged one
};

/// `what`: "the edit is "; `why`: a failure of CheckpointWriter.
[[nodiscard]] msg::Cause not_persisted(const std::string& what, const std::string& why);

}  // namespace hecaton::services
