#include "services/recorder/ros2_track.hpp"

#include <chrono>

#include "services/bus/recorded_sample.hpp"

namespace hecaton::services::recorder {
namespace {

bus::Clock::time_point time_of(std::uint64_t nanoseconds) {
  return bus::Clock::time_point(std::chrono::nanoseconds(nanoseconds));
}

template <class T>
bool is_of(const RecordedSample& recorded) {
  return bus::kTopics[recorded.sample.topic].name == bus::Topic<T>::kInfo.name;
}

template <class T>
void apply_to(CellState& cell, const RecordedSample& recorded) {
  bus::Sample<T> sample;
  sample.key = recorded.sample.key;
  sample.received = time_of(recorded.log_time);
  sample.writer = recorded.sample.writer;
  sample.disposed = recorded.sample.withdrawn;
  if (!sample.disposed) {
    auto decoded = bus::decode_recorded<T>(recorded.sample.bytes);
    if (!decoded.value) return;  // RawReaders have checked it
    sample.value = std::move(*decoded.value);
    sample.key = bus::key_of(sample.value);
  }
  cell.apply(sample);
}

/// Applies it when its type is one of these.
template <class... T>
void apply_one_of(CellState& cell, const RecordedSample& recorded) {
  (void)((is_of<T>(recorded) && (apply_to<T>(cell, recorded), true)) || ...);
}

}  // namespace

Ros2Track::Ros2Track(const config::CellFile& file, Recording& recording, std::uint64_t now)
    : recording_(recording), cell_(file, time_of(now)), stream_(file) {
  std::vector<MadeTopic> topics;
  for (const Ros2Topic& topic : stream_.topics()) {
    topics.push_back(
        {topic.name, topic.type, Ros2Stream::definition(topic), Ros2Stream::channel_metadata(topic), topic.latched});
  }
  recording_.set_made_topics(std::move(topics));
  stream_.write_fixed(time_of(now),
                      [&](std::size_t topic, const Bytes& cdr) { recording_.write_made(topic, cdr, now); });
}

void Ros2Track::take(const RecordedSample& recorded) {
  const bool often =
      is_of<msg::ArmState>(recorded) || is_of<msg::ObstacleStates>(recorded) || is_of<msg::Heartbeat>(recorded);
  if (often && !recorded.sample.withdrawn) {
    waiting_.insert_or_assign({recorded.sample.topic, recorded.sample.key}, recorded);
    return;
  }
  waiting_.erase({recorded.sample.topic, recorded.sample.key});
  apply(recorded);
}

void Ros2Track::apply(const RecordedSample& recorded) {
  apply_one_of<msg::ArmState, msg::ObstacleStates, msg::Heartbeat, msg::GoalStatus, msg::ObstacleShapes,
               msg::PlannedMotion, msg::Fault, msg::CellMode>(cell_, recorded);
}

void Ros2Track::write_due(std::uint64_t now) {
  if (now < due_at_) return;
  due_at_ = now + static_cast<std::uint64_t>(std::chrono::nanoseconds(stream_.period()).count());
  for (const auto& [key, recorded] : waiting_) apply(recorded);
  waiting_.clear();
  stream_.write_due(cell_, time_of(now),
                    [&](std::size_t topic, const Bytes& cdr) { recording_.write_made(topic, cdr, now); });
}

}  // namespace hecaton::services::recorder
