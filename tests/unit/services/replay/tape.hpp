#pragma once
/// Recordings with known messages, for tests.

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/topics.hpp"
#include "services/config/cell_file.hpp"
#include "services/recorder/recorder.hpp"
#include "services/recorder/recording.hpp"
#include "tests/support/cdr.hpp"

namespace hecaton::services::replay {

inline const std::string kCell = std::string(HECATON_SOURCE_DIR) + "/deploy/cells/three_puma.yaml";
inline const bus::Clock::time_point kBegan{std::chrono::seconds(1'700'000'000)};

inline std::uint64_t unix_ns(bus::Clock::time_point time) {
  return static_cast<std::uint64_t>(time.time_since_epoch().count());
}

inline const config::CellFile& cell_file() {
  static const config::CellFile file = config::load_cell_file(kCell);
  return file;
}

template <class T>
std::size_t topic_index() {
  for (std::size_t i = 0; i < bus::kTopics.size(); ++i) {
    if (bus::kTopics[i].name == bus::Topic<T>::kInfo.name) return i;
  }
  return bus::kTopics.size();
}

/// Writes messages at given times after kBegan.
class Tape {
 public:
  explicit Tape(recorder::RecordingOptions options, const config::CellFile& file = cell_file())
      : recording_(std::move(options), recorder::attachments_of(file), unix_ns(kBegan)) {}

  template <class T>
  void write(const T& message, bus::Clock::duration at, std::uint8_t writer = 1) {
    recorder::RecordedSample recorded = sample<T>(bus::key_of(message), at, writer);
    recorded.sample.bytes = test::cdr_of(message);
    put(std::move(recorded));
  }
  template <class T>
  void withdraw(const std::string& key, bus::Clock::duration at) {
    recorder::RecordedSample recorded = sample<T>(key, at, 1);
    recorded.sample.withdrawn = true;
    put(std::move(recorded));
  }
  std::vector<std::string> close() {
    recording_.close();
    return recording_.files();
  }

 private:
  template <class T>
  recorder::RecordedSample sample(const std::string& key, bus::Clock::duration at, std::uint8_t writer) {
    recorder::RecordedSample recorded;
    recorded.sample.topic = topic_index<T>();
    recorded.sample.key = key;
    recorded.sample.writer.bytes[0] = writer;
    recorded.sample.number = ++number_;
    recorded.log_time = unix_ns(kBegan + at);
    return recorded;
  }
  void put(recorder::RecordedSample recorded) {
    const std::uint64_t now = recorded.log_time;
    recording_.write(std::move(recorded));
    recording_.keep_up(now);
  }

  recorder::Recording recording_;
  std::uint64_t number_ = 0;
};

inline msg::ArmState arm_state(const std::string& arm, std::uint64_t number) {
  msg::ArmState state;
  state.arm(arm);
  state.sequence_number(number);
  state.mode(msg::ArmMode::ARM_RUNNING);
  state.q(std::vector<double>(6, 1e-4 * static_cast<double>(number)));
  state.qd(std::vector<double>(6, 0.01));
  return state;
}

/// Why a function throws.
inline std::string error_of(const std::function<void()>& refused) {
  try {
    refused();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace hecaton::services::replay
