#pragma once
/// The topics of ROS 2 in a recording: what hecaton-ros2 would send, for programs that know no other types.

#include <map>
#include <string>
#include <utility>

#include "services/config/cell_file.hpp"
#include "services/recorder/recording.hpp"
#include "services/view/ros2_stream.hpp"

namespace hecaton::services::recorder {

/// For one thread.
class Ros2Track {
 public:
  /// Writes what never changes. Both must outlive it. `now`: since 1970 [ns]. Throws RecordingError.
  Ros2Track(const config::CellFile& file, Recording& recording, std::uint64_t now);

  void take(const RecordedSample& recorded);
  /// Writes what is due. Throws RecordingError.
  void write_due(std::uint64_t now);

 private:
  /// Of topics that are sent often the newest of each key, which is decoded only when a message is due.
  using Waiting = std::map<std::pair<std::size_t, std::string>, RecordedSample>;

  void apply(const RecordedSample& recorded);

  Recording& recording_;
  CellState cell_;
  Ros2Stream stream_;
  Waiting waiting_;
  std::uint64_t due_at_ = 0;  ///< [ns]
};

}  // namespace hecaton::services::recorder
