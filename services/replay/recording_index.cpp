#include "services/replay/recording_index.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <optional>

#include "services/replay/message_feeder.hpp"

namespace hecaton::services::replay {
namespace {

using namespace std::chrono_literals;
using recorder::McapMessage;
using recorder::RecordingError;

/// A part that begins later than this after the former one has states missing in between.
constexpr auto kGap = 5s;
/// The readers of a recorder note the times of their samples beside each other.
constexpr auto kDisorder = 100ms;
constexpr auto kProgressPeriod = 100ms;

/// Time of the first message that belongs to this file; empty: it has none.
std::optional<bus::Clock::time_point> begin_of(const std::string& path) {
  std::optional<bus::Clock::time_point> begin;
  recorder::McapVisitor visitor;
  visitor.message = [&](const McapMessage& message) {
    if (!begin && is_of_cell(*message.channel) && !is_repeated(*message.channel)) begin = time_of(message);
  };
  visitor.chunk = [&](std::uint64_t) { return !begin; };
  recorder::read_mcap(path, visitor);
  return begin;
}

std::uint64_t size_of(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

class Indexing {
 public:
  Indexing(const config::CellFile& file, const std::function<void(double)>& progress)
      : progress_(progress), state_(file, {}), feeder_(state_, &finder_) {}

  RecordingIndex run(const std::vector<std::string>& paths) {
    for (const std::string& path : paths) total_ += size_of(path);
    for (const std::string& path : paths) read_part(path);
    feeder_.flush();
    refuse_useless(paths);
    index_.end = newest_;
    index_.marks = finder_.take_marks();
    if (finder_.left_out() > 0) {
      index_.notes.push_back("the time line lacks " + std::to_string(finder_.left_out()) +
                             " marks: it has the first 5000 of faults, of goals and of modes");
    }
    return std::move(index_);
  }

 private:
  void read_part(const std::string& path) {
    const auto begin = begin_of(path);
    if (!begin) {
      index_.notes.push_back(path + " has no messages of a cell");
      read_ += size_of(path);
      return;
    }
    const bool first = index_.parts.empty();
    if (!first && *begin + kDisorder < newest_) {
      throw RecordingError(path + " begins before " + index_.parts.back().path +
                           " ends; name the files of one recording, in their order");
    }
    const auto former = newest_;
    RecordedPart& part = index_.parts.emplace_back();
    part.path = path;
    part.begin = *begin;
    part.continues = !first && *begin - newest_ <= kGap;
    if (first) index_.begin = newest_ = *begin;
    if (!part.continues) {
      feeder_.flush();
      state_.begin_anew(*begin);
      newest_ = std::max(newest_, *begin);  // until then the former state is shown
    }
    if (!first && !part.continues) {
      index_.notes.push_back("nothing was recorded for " +
                             std::to_string(std::chrono::duration_cast<std::chrono::seconds>(*begin - former).count()) +
                             " s before " + path);
    }
    recorder::McapVisitor visitor;
    visitor.chunk = [&](std::uint64_t at) {
      begin_chunk(at);
      return true;
    };
    visitor.message = [&](const McapMessage& message) { take(message); };
    recorder::McapReport report = recorder::read_mcap(path, visitor);
    read_ += report.bytes;
    part.channels = std::move(report.channels);
    note_damages(path, report);
  }

  void begin_chunk(std::uint64_t at) {
    chunk_at_ = at;
    chunk_is_new_ = true;
    const auto now = std::chrono::steady_clock::now();
    if (!progress_ || now - progress_at_ < kProgressPeriod) return;
    progress_at_ = now;
    progress_(total_ == 0 ? 1.0 : static_cast<double>(read_ + at) / static_cast<double>(total_));
  }

  void take(const McapMessage& message) {
    if (chunk_is_new_) add_chunk();
    chunk_is_new_ = false;
    if (is_repeated(*message.channel) && index_.parts.back().continues) return;
    if (is_of_cell(*message.channel)) newest_ = std::max(newest_, time_of(message));
    feeder_.take(message);
  }

  void add_chunk() {
    if (index_.chunks.size() % stride_ == 0) {
      feeder_.flush();
      index_.checkpoints.push_back({index_.chunks.size(), state_});
    }
    index_.chunks.push_back({index_.parts.size() - 1, chunk_at_, newest_});
    if (index_.checkpoints.size() <= RecordingIndex::kMostCheckpoints) return;
    stride_ *= 2;
    std::erase_if(index_.checkpoints, [&](const Checkpoint& checkpoint) { return checkpoint.chunk % stride_ != 0; });
  }

  void note_damages(const std::string& path, const recorder::McapReport& report) {
    if (report.cut) {
      index_.notes.push_back(path + " has no end: its recorder was killed, had no room on the disk, or still writes");
    }
    for (const std::string& damage : report.damages) index_.notes.push_back(path + ": " + damage);
    index_.whole = index_.whole && report.whole();
  }

  void refuse_useless(const std::vector<std::string>& paths) {
    if (index_.chunks.empty()) {
      throw RecordingError(paths.front() + " has no messages of a cell that can be read; name another recording");
    }
    const UndecodedMessages& undecoded = feeder_.undecoded();
    if (!undecoded.refused.empty() && feeder_.decoded() == 0) {
      throw RecordingError(paths.front() + ": " + undecoded.refused.begin()->first +
                           ". `hecaton bag info` works with every version");
    }
    for (std::string& note : feeder_.notes()) index_.notes.push_back(std::move(note));
    for (const auto& [sentence, count] : undecoded.refused) {
      index_.notes.push_back(std::to_string(count) + " messages are left out: " + sentence);
    }
    if (undecoded.broken > 0) {
      index_.notes.push_back(std::to_string(undecoded.broken) +
                             " messages break a rule of the wire and are left out; were they recorded by Hecaton?");
    }
  }

  const std::function<void(double)>& progress_;
  RecordingIndex index_;
  CellState state_;
  MarkFinder finder_;
  MessageFeeder feeder_;
  bus::Clock::time_point newest_;  ///< of all messages so far
  std::size_t stride_ = 1;         ///< chunks between two checkpoints
  std::uint64_t chunk_at_ = 0;
  bool chunk_is_new_ = false;
  std::uint64_t total_ = 0;  ///< bytes
  std::uint64_t read_ = 0;   ///< bytes of former files
  std::chrono::steady_clock::time_point progress_at_;
};

}  // namespace

RecordingIndex index_recording(const std::vector<std::string>& paths, const config::CellFile& file,
                               const std::function<void(double)>& progress) {
  return Indexing(file, progress).run(paths);
}

}  // namespace hecaton::services::replay
