#pragma once
/// What a recording contains, and its messages as CSV files.

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "services/recorder/host_clocks.hpp"
#include "services/recorder/losses.hpp"
#include "services/recorder/mcap_reader.hpp"

namespace hecaton::services::recorder {

struct TopicFigures {
  std::string schema;    ///< "hecaton::msg::ArmState"; empty: none
  std::string encoding;  ///< of its messages
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;      ///< of messages, not compressed
  std::uint64_t first = 0;      ///< log time [ns]
  std::uint64_t last = 0;       ///< log time [ns]
  std::set<std::string> nodes;  ///< that have written it; "": unknown ones
};

struct BagFile {
  std::string name;
  std::string media_type;
  std::uint64_t bytes = 0;
};

struct BagInfo {
  McapReport file;
  std::map<std::string, TopicFigures> topics;  ///< by name
  std::vector<BagFile> attachments;
  std::optional<std::string> cell;             ///< its name; empty: the recording does not tell
  std::map<std::string, TopicLosses> losses;   ///< by topic, as the recorder reported them last
  bool has_losses = false;                     ///< the recorder has reported them
  std::map<std::string, ClockFigures> clocks;  ///< by host
  std::uint64_t first = 0;                     ///< log time of topics, without repeated messages [ns]
  std::uint64_t last = 0;                      ///< the same
  bool simulated = false;                      ///< its times are virtual, from 0

  [[nodiscard]] double duration() const;  ///< [s]
};

/// Throws RecordingError with a sentence when the file is no recording.
[[nodiscard]] BagInfo bag_info(const std::string& path);

struct ExportedTopic {
  std::string file;
  std::uint64_t rows = 0;
  std::uint64_t skipped = 0;  ///< messages that a rule refuses, or that cannot be converted to this program's version
  std::string reason;         ///< why the last one was skipped
};

struct ExportReport {
  std::vector<McapReport> files;                ///< one for each path
  std::map<std::string, ExportedTopic> topics;  ///< by name
  std::vector<std::string> notes;               ///< what a reader must know of them, a sentence each
};

/// Writes one CSV file for each topic of Hecaton into `folder`, which it makes if it is missing. `paths`: a recording,
/// or the files of a split one in their order. Throws RecordingError with a sentence, also when one of the files exists
/// already or the disk is full; then it removes the files that it has made.
ExportReport export_csv(const std::vector<std::string>& paths, const std::string& folder);

}  // namespace hecaton::services::recorder
