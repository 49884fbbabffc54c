#pragma once
/// The checkpoint of a supervisor: its term, people's orders and the faults, from which a successor of a killed process
/// continues.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "services/supervisor/cell_mode.hpp"
#include "services/supervisor/fault_list.hpp"

namespace hecaton::services {

struct Checkpoint {
  std::uint64_t term = 0;
  Orders orders;
  CausesByArm causes;
  FaultHistory faults;
  Orders unreplicated;  ///< part of `orders` that the other supervisor may not have
  bool operator==(const Checkpoint&) const = default;
};

/// Lines:
///
///   term N
///   cell MODE
///   arm NAME MODE
///   because NAME KIND SUBJECT TEXT…
///   speed NAME SHARE
///   unreplicated NAME MODE
///   unreplicated_speed NAME SHARE
///   fault TERM NUMBER KIND SEVERITY SINCE LATENCY_BOUND open|CLEARED_AT KEY|- SUBJECT DESCRIPTION…
///
/// NAME "/" is the whole cell. A speed of 1 has no line. Times are in nanoseconds of the steady clock; LATENCY_BOUND
/// −1: unknown.
[[nodiscard]] std::string checkpoint_text(const Checkpoint& checkpoint);
/// Empty when `text` is malformed.
[[nodiscard]] std::optional<Checkpoint> parse_checkpoint(const std::string& text);

/// Empty when the file does not exist. Throws std::runtime_error with a sentence when it cannot be used, because an
/// order to stop must not be lost silently.
[[nodiscard]] std::optional<Checkpoint> read_checkpoint(const std::string& path);
/// Replaces the file as a whole, as write_atomically() does. Returns nothing, or a sentence that says why it
/// cannot be written; the former checkpoint then stays.
[[nodiscard]] std::optional<std::string> write_checkpoint(const std::string& path, const Checkpoint& checkpoint);

/// The newest checkpoint and its file.
class CheckpointFile {
 public:
  /// Reads the checkpoint of the previous process. Empty path: nothing is stored. A file that cannot be used is set
  /// aside under the name "PATH.unusable", see lost().
  explicit CheckpointFile(std::string path);

  /// Call it before the contents are published. A failed write is tried again, also if `checkpoint` has not changed.
  void store(Checkpoint checkpoint) {
    const bool is_stored = checkpoint == stored_;
    if (path_.empty() || (is_stored && !failed())) return;
    failure_ = is_stored ? std::nullopt : write_checkpoint(path_, checkpoint);
    if (!failed()) stored_ = std::move(checkpoint);
  }
  [[nodiscard]] bool has_file() const { return !path_.empty(); }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// As last written or read.
  [[nodiscard]] const Checkpoint& stored() const { return stored_; }
  /// The newest checkpoint could not be written.
  [[nodiscard]] bool failed() const { return failure_.has_value(); }
  /// A sentence when the previous process has left a checkpoint that cannot be used: its orders are unknown.
  [[nodiscard]] const std::optional<std::string>& lost() const { return lost_; }
  /// Why, as a sentence. Only while failed().
  [[nodiscard]] std::string failure() const {
    return "new orders and faults would be lost with this process, because their checkpoint cannot be written: " +
           failure_.value();
  }

 private:
  std::string path_;
  Checkpoint stored_;
  std::optional<std::string> failure_;  // of the last write
  std::optional<std::string> lost_;
};

}  // namespace hecaton::services
