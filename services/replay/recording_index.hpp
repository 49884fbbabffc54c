#pragma once
/// The index of a recording, from one reading of its files: where the chunks are, checkpoints of the cell's state, and
/// marks. With it, the state at any time is a checkpoint and the messages of a few chunks.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "services/config/cell_file.hpp"
#include "services/recorder/mcap_reader.hpp"
#include "services/replay/marks.hpp"
#include "services/view/cell_state.hpp"

namespace hecaton::services::replay {

/// A file of the recording.
struct RecordedPart {
  std::string path;
  recorder::McapChannels channels;
  /// The part goes on where the former one ends. Otherwise the state of the cell begins anew with it.
  bool continues = false;
  bus::Clock::time_point begin;  ///< of its first message
};

struct RecordedChunk {
  std::size_t part = 0;
  std::uint64_t at = 0;           ///< byte in the file
  bus::Clock::time_point before;  ///< from this time on the state before the chunk is shown
};

/// The state of the cell before a chunk.
struct Checkpoint {
  std::size_t chunk = 0;
  CellState state;
};

struct RecordingIndex {
  static constexpr std::size_t kMostCheckpoints = 256;

  std::vector<RecordedPart> parts;
  std::vector<RecordedChunk> chunks;    ///< with messages, by time
  std::vector<Checkpoint> checkpoints;  ///< by chunk; the first is that of the first chunk
  std::vector<Mark> marks;              ///< by time
  /// What a reader must know, a sentence each: what is damaged, cut or left out. Empty: nothing.
  std::vector<std::string> notes;
  bool whole = true;             ///< no file is damaged or cut
  bus::Clock::time_point begin;  ///< of the first message of the cell
  bus::Clock::time_point end;    ///< of the last one
};

/// Reads all files, which follow each other in time. `file` must outlive the index. `progress`: called with the share
/// that was read, some times a second; empty: not called. Throws RecordingError with a sentence: a file that cannot be
/// read, without messages of a cell, or without one that can be converted to this version of Hecaton, or that does not
/// follow the former file.
[[nodiscard]] RecordingIndex index_recording(const std::vector<std::string>& paths, const config::CellFile& file,
                                             const std::function<void(double share)>& progress = {});

}  // namespace hecaton::services::replay
