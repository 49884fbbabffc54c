#pragma once
/// A recording that a command reads.

#include <memory>
#include <string>
#include <vector>

#include "services/replay/recorded_cell.hpp"
#include "services/replay/recorded_files.hpp"
#include "services/replay/recording_index.hpp"

namespace CLI {
class App;
}

namespace hecaton::services::cli {

/// Adds the positional FILE… to a command.
void add_recording_files(CLI::App& command, std::vector<std::string>& files);

/// Its members refer to each other: neither copied nor moved.
struct OpenedRecording {
  /// Shows the progress on a terminal. Throws std::runtime_error with a sentence.
  explicit OpenedRecording(const std::vector<std::string>& paths);
  OpenedRecording(const OpenedRecording&) = delete;
  OpenedRecording& operator=(const OpenedRecording&) = delete;

  [[nodiscard]] double length() const;  ///< [s]

  replay::RecordedFiles files;
  replay::RecordingIndex index;
  replay::RecordedCell cell;
};

/// Prints what is damaged or left out. Throws Failure (bad input).
[[nodiscard]] std::unique_ptr<OpenedRecording> open_recording(const std::vector<std::string>& paths);

/// `at`: since the begin of the recording [s]. Throws Failure (bad input), which names `option`, for a time outside.
[[nodiscard]] bus::Clock::time_point time_in(const OpenedRecording& recording, double at, const std::string& option);

}  // namespace hecaton::services::cli
