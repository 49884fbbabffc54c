#include "services/replay/recorded_cell.hpp"

#include <algorithm>
#include <utility>

namespace hecaton::services::replay {

using recorder::McapMessage;

RecordedCell::RecordedCell(const RecordingIndex& index)
    : index_(index), state_(index.checkpoints.front().state), feeder_(state_), now_(index.begin) {
  return_to(index_.checkpoints.front());
  move_to(index_.begin);
}

void RecordedCell::return_to(const Checkpoint& checkpoint) {
  feeder_.drop();
  state_ = checkpoint.state;
  chunk_ = checkpoint.chunk;
  message_ = 0;
  entered_ = true;  // the checkpoint was made behind it
  newest_ = index_.chunks[chunk_].before;
}

bool RecordedCell::enter_chunk(bus::Clock::time_point time) {
  if (std::exchange(entered_, true) || chunk_ == 0) return true;
  const std::size_t number = index_.chunks[chunk_].part;
  const RecordedPart& part = index_.parts[number];
  if (number == index_.chunks[chunk_ - 1].part || part.continues) return true;
  if (time < part.begin) {
    entered_ = false;
    return false;
  }
  feeder_.drop();
  state_.begin_anew(part.begin);
  newest_ = std::max(newest_, part.begin);
  return true;
}

void RecordedCell::move_to(bus::Clock::time_point time) {
  time = std::clamp(time, index_.begin, index_.end);
  const auto later = std::partition_point(
      index_.checkpoints.begin(), index_.checkpoints.end(),
      [&](const Checkpoint& checkpoint) { return index_.chunks[checkpoint.chunk].before <= time; });
  const Checkpoint& nearest = later == index_.checkpoints.begin() ? *later : *std::prev(later);
  if (time < now_ || nearest.chunk > chunk_) return_to(nearest);
  now_ = time;
  while (chunk_ < index_.chunks.size() && enter_chunk(time) && take_until(time)) {
    ++chunk_;
    message_ = 0;
    entered_ = false;
  }
  feeder_.flush();
}

bool RecordedCell::take_until(bus::Clock::time_point time) {
  const std::vector<McapMessage>& messages = load(chunk_).messages;
  const bool continues = index_.parts[index_.chunks[chunk_].part].continues;
  for (; message_ < messages.size(); ++message_) {
    const McapMessage& message = messages[message_];
    if (is_repeated(*message.channel) && continues) continue;
    const auto at = std::max(newest_, time_of(message));
    if (at > time) return false;
    if (is_of_cell(*message.channel)) newest_ = at;
    feeder_.take(message);
  }
  return true;
}

const RecordedCell::Loaded& RecordedCell::load(std::size_t chunk) {
  if (loaded_[0].chunk == chunk) return loaded_[0];
  std::swap(loaded_[0], loaded_[1]);
  Loaded& loaded = loaded_[0];
  if (loaded.chunk == chunk) return loaded;
  const RecordedChunk& place = index_.chunks[chunk];
  if (place.part != part_) {
    const RecordedPart& part = index_.parts[place.part];
    reader_ = std::make_unique<recorder::McapChunks>(part.path, part.channels);
    part_ = place.part;
  }
  loaded.chunk = kNone;  // until it is read
  loaded.messages = reader_->messages(place.at, loaded.records);
  loaded.chunk = chunk;
  return loaded;
}

std::optional<bus::Clock::time_point> RecordedCell::next_state(const std::string& arm) {
  return next({bus::Topic<msg::ArmState>::kInfo.name, arm, kLongestStep});
}
std::optional<bus::Clock::time_point> RecordedCell::previous_state(const std::string& arm) {
  return previous({bus::Topic<msg::ArmState>::kInfo.name, arm, kLongestStep});
}
std::optional<bus::Clock::time_point> RecordedCell::next_tick(const std::string& arm) {
  return next({bus::Topic<msg::PlannerTick>::kInfo.name, arm, kLongestTick});
}
std::optional<bus::Clock::time_point> RecordedCell::previous_tick(const std::string& arm) {
  return previous({bus::Topic<msg::PlannerTick>::kInfo.name, arm, kLongestTick});
}

bool RecordedCell::matches(const McapMessage& message, const Wanted& wanted) {
  if (message.channel->topic != wanted.topic) return false;
  if (wanted.arm.empty()) return true;
  const auto key = key_in(searched_.of(message).data);
  return key && *key == wanted.arm;
}

std::optional<bus::Clock::time_point> RecordedCell::next(const Wanted& wanted) {
  auto at = newest_;
  std::size_t message = message_;
  for (std::size_t chunk = chunk_; chunk < index_.chunks.size(); ++chunk, message = 0) {
    const std::vector<McapMessage>& messages = load(chunk).messages;
    for (; message < messages.size(); ++message) {
      if (is_of_cell(*messages[message].channel)) at = std::max(at, time_of(messages[message]));
      if (at - now_ > wanted.longest) return std::nullopt;
      if (at > now_ && matches(messages[message], wanted)) return at;
    }
  }
  return std::nullopt;
}

std::optional<bus::Clock::time_point> RecordedCell::previous(const Wanted& wanted) {
  for (std::size_t chunk = std::min(chunk_ + 1, index_.chunks.size()); chunk-- > 0;) {
    auto at = index_.chunks[chunk].before;
    std::optional<bus::Clock::time_point> found;
    for (const McapMessage& message : load(chunk).messages) {
      if (is_of_cell(*message.channel)) at = std::max(at, time_of(message));
      if (at >= now_) break;
      if (at >= index_.begin && matches(message, wanted)) found = at;
    }
    if (found) return now_ - *found > wanted.longest ? std::nullopt : found;
    if (now_ - index_.chunks[chunk].before > wanted.longest) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace hecaton::services::replay
