#include "services/cli/opened_recording.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <stdexcept>

#include <CLI/CLI.hpp>

#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

replay::RecordingIndex indexed(const std::vector<std::string>& paths, const config::CellFile& file) {
  Progress progress;
  return replay::index_recording(
      paths, file, [&](double share) { progress.show("reading " + paths.front(), share * 100.0, 100.0, "%"); });
}

}  // namespace

OpenedRecording::OpenedRecording(const std::vector<std::string>& paths)
    : files(replay::read_recorded_files(paths)), index(indexed(paths, files.cell)), cell(index) {}

double OpenedRecording::length() const {
  return std::chrono::duration<double>(index.end - index.begin).count();
}

void add_recording_files(CLI::App& command, std::vector<std::string>& files) {
  command.add_option("FILE", files, "recording (.mcap); the files of a split recording in their order")
      ->required()
      ->expected(1, 10000);
}

std::unique_ptr<OpenedRecording> open_recording(const std::vector<std::string>& paths) {
  try {
    auto opened = std::make_unique<OpenedRecording>(paths);
    for (const std::string& note : opened->index.notes) std::fprintf(stderr, "hecaton: %s\n", note.c_str());
    return opened;
  } catch (const std::runtime_error& error) {
    throw Failure(ExitCode::kBadInput, error.what());
  }
}

bus::Clock::time_point time_in(const OpenedRecording& recording, double at, const std::string& option) {
  constexpr double kHalfOfPrinted = 5e-4;  // the length that people read has milliseconds
  if (at > recording.length() + kHalfOfPrinted) {
    throw Failure(ExitCode::kBadInput, option + " " + decimal_text(at, 3) +
                                           " is behind the end of the recording, which has " +
                                           decimal_text(recording.length(), 3) + " s");
  }
  const auto since_begin = std::chrono::duration_cast<bus::Clock::duration>(std::chrono::duration<double>(at));
  return std::min(recording.index.begin + since_begin, recording.index.end);
}

}  // namespace hecaton::services::cli
