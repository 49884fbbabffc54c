#pragma once
/// Records all topics of a running cell. It only receives; the cell does not know it.

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/bus/participant.hpp"
#include "services/bus/raw_reader.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/host_clocks.hpp"
#include "services/recorder/losses.hpp"
#include "services/recorder/recording.hpp"
#include "services/recorder/ros2_track.hpp"

namespace hecaton::services::recorder {

/// For one thread.
class Recorder {
 public:
  /// Samples that wait for the disk. More are dropped and counted [byte].
  static constexpr std::size_t kMostWaiting = std::size_t{64} << 20U;

  /// Period in which take() is to be called.
  static constexpr std::chrono::milliseconds kPeriod{20};

  /// Creates the file. `file`, `participant` and `mailbox`, the participant's own, must outlive it. The participant
  /// must have no typed endpoints. Throws RecordingError when the file cannot be created.
  Recorder(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox,
           const RecordingOptions& recording);

  /// Records what has arrived. Throws RecordingError when the file cannot be written; then only the destructor may
  /// follow.
  void take();
  /// Records what has arrived, and closes the file. Throws RecordingError.
  void close();
  /// Recording::save(), until `duration` from now.
  void save(std::chrono::nanoseconds duration) { recording_.save(unix_time(bus::Clock::now() + duration)); }

  [[nodiscard]] const Recording& recording() const { return recording_; }
  /// Removes the files of the recording; after close().
  void remove_files() { recording_.remove_files(); }
  [[nodiscard]] std::chrono::nanoseconds duration() const { return bus::Clock::now() - began_; }
  /// As in the last report: one for each topic of bus::kTopics.
  [[nodiscard]] const std::vector<TopicLosses>& losses() const { return reported_; }

 private:
  /// First 12 bytes of the identity of each endpoint.
  using ParticipantId = std::array<std::uint8_t, 12>;

  void receive();
  void note_clock(const bus::RawSample& sample);
  void report();
  void report_losses(bus::Clock::time_point now);
  void report_clocks(bus::Clock::time_point now);
  [[nodiscard]] std::uint64_t unix_time(bus::Clock::time_point time) const;

  const config::CellFile& file_;
  bus::Clock::time_point began_ = bus::Clock::now();
  std::chrono::nanoseconds clock_offset_;  ///< of the wall clock when the recording began
  bus::Mailbox& mailbox_;
  Recording recording_;
  bus::RawReaders readers_;
  LossCounter losses_;
  HostClocks clocks_;
  std::optional<Ros2Track> ros2_;
  std::map<ParticipantId, std::string> nodes_;
  std::vector<TopicLosses> reported_;
  bus::Clock::time_point report_at_{};
};

/// Media type of attached YAML files.
inline constexpr std::string_view kYamlFile = "application/yaml";

/// The meshes with which a recording's arms are drawn, with their textures [byte].
inline constexpr std::uintmax_t kMostMeshes = std::uintmax_t{32} << 20U;

/// The cell file first, then all files that it was read from: robots, and meshes of their collision shapes. With them a
/// recording opens on any machine. xacro files are attached as the URDF that they gave. Then the meshes with which arms
/// are drawn: all of an arm or none, and at most `most_meshes` bytes together.
[[nodiscard]] std::vector<AttachedFile> attachments_of(const config::CellFile& file,
                                                       std::uintmax_t most_meshes = kMostMeshes);

}  // namespace hecaton::services::recorder
