#pragma once
/// What a supervisor that was killed must still know when it starts again: its term, people's orders and the faults. A
/// text file, replaced as a whole: a crash leaves either the old or the new one. Two files take turns, and their room
/// is taken beforehand: a disk that is full by then loses no order. Pure, but for the file.

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
  Orders unreplicated;  ///< of the orders: those that the other supervisor is not known to have
  bool operator==(const Checkpoint&) const = default;
};

/// Lines "term N", "cell MODE", "arm NAME MODE", "because NAME KIND SUBJECT TEXT…" ("/": of the cell's), "unreplicated
/// NAME MODE" (likewise), and for each fault "fault LIFE NUMBER KIND SEVERITY SINCE WITHIN CLEARED|open CAUSE|- SUBJECT
/// SEEN…" (times in nanoseconds, of the steady clock; WITHIN −1: unknown).
[[nodiscard]] std::string checkpoint_text(const Checkpoint& checkpoint);
/// Empty when it is no such text.
[[nodiscard]] std::optional<Checkpoint> parse_checkpoint(const std::string& text);

/// Empty when there is no such file. Throws std::runtime_error with a sentence when it is there and cannot be used: an
/// order to stop must not be forgotten silently.
[[nodiscard]] std::optional<Checkpoint> read_checkpoint(const std::string& path);
/// Empty lines fill up the room. Empty, or the sentence that says why it cannot be written: what was remembered before
/// still is.
[[nodiscard]] std::string write_checkpoint(const std::string& path, const Checkpoint& checkpoint);
/// Where the other of its two files is.
[[nodiscard]] std::string other_checkpoint(const std::string& path);

/// The checkpoint in its file, and whether it found room there.
class CheckpointFile {
 public:
  /// Reads what an earlier life wrote. Empty path: nothing is kept. Throws as read_checkpoint() does.
  explicit CheckpointFile(std::string path) : path_(std::move(path)) {
    if (auto checkpoint = path_.empty() ? std::nullopt : read_checkpoint(path_)) kept_ = *std::move(checkpoint);
  }

  /// To be called before its contents are published: what a reader has received is never forgotten. A write that failed
  /// is tried again, also when `checkpoint` is nothing new.
  void keep(Checkpoint checkpoint) {
    const bool known = checkpoint == kept_;
    if (path_.empty() || (known && !failed())) return;
    const std::string refusal = known ? std::string() : write_checkpoint(path_, checkpoint);
    failure_ = refusal.empty() ? std::nullopt : std::optional(refusal);
    if (!failed()) kept_ = std::move(checkpoint);
  }
  [[nodiscard]] bool keeps() const { return !path_.empty(); }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// As last written.
  [[nodiscard]] const Checkpoint& kept() const { return kept_; }
  /// The newest checkpoint could not be written.
  [[nodiscard]] bool failed() const { return failure_.has_value(); }
  /// Why, as a sentence. Only while failed().
  [[nodiscard]] std::string failure() const {
    return "orders and faults are not remembered, and are lost with this process: " + failure_.value();
  }

 private:
  std::string path_;
  Checkpoint kept_;
  std::optional<std::string> failure_;  // it could not be written, last
};

}  // namespace hecaton::services
