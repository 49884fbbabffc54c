#include "services/cli/simulation_recording.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include <idl/planner.h>

#include "services/bus/recorded_sample.hpp"
#include "services/command_line/program.hpp"
#include "services/recorder/recorder.hpp"
#include "services/runtime/node_name.hpp"
#include "services/tick_log/program.hpp"
#include "services/tick_log/tick_writer.hpp"

namespace hecaton::services::cli {
namespace {

recorder::Recording begin(const std::string& path, const config::CellFile& file, const CellChanges& changes) {
  try {
    std::vector<recorder::AttachedFile> attached = recorder::attachments_of(file);
    attached.push_back({std::string(CellChanges::kAttachment), "application/json", changes.json()});
    return recorder::Recording({.path = path}, std::move(attached), 0);
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, std::string("--record: ") + error.what());
  }
}

std::size_t topic_of_ticks() {
  std::size_t index = 0;
  while (bus::kTopics[index].name != bus::Topic<msg::PlannerTick>::kInfo.name) ++index;
  return index;
}

std::uint64_t nanoseconds_of(double seconds) {
  return static_cast<std::uint64_t>(std::llround(seconds * 1e9));
}

}  // namespace

/// One planner for each arm. The threads of an episode share no arm.
class SimulationRecording::EpisodeTicks {
 public:
  EpisodeTicks(SimulationRecording& recording, int episode, const planner::Cell& cell)
      : recording_(recording),
        writer_(static_cast<std::uint32_t>(episode) % writers_of(cell)),
        begin_(static_cast<double>(episode) * cell.tasks.time_limit),
        obstacles_(std::make_shared<const std::vector<world::Obstacle>>(cell.scene.obstacles)),
        names_(names_of(cell)),
        arms_(cell.arms.size()) {}

  void take(const planner::PlannerPeriod& period) {
    ArmTicks& arm = arms_[static_cast<std::size_t>(period.arm)];
    const std::string& name = names_[static_cast<std::size_t>(period.arm)];
    if (!arm.writer) {
      arm.writer.emplace(name, period.arm, planner_node(name));
      arm.snapshot = TickWriter::Snapshot{{}, program_text(), period.options, obstacles_};
    }
    arm.writer->begin(static_cast<std::int64_t>(nanoseconds_of(period.time)), period.events, arm.snapshot);
    arm.writer->finish(period.inputs, period.result);
    if (arm.snapshot) arm.snapshot_due = period.time + TickWriter::kSnapshotPeriod;
    arm.snapshot.reset();
    write(period.arm, name, *arm.writer, begin_ + period.time);
    if (period.time + period.options.control_period < arm.snapshot_due) return;
    std::vector<std::uint32_t> memory = period.planner.save();
    if (memory.empty()) return;
    arm.snapshot = TickWriter::Snapshot{std::move(memory), program_text(), period.options, obstacles_};
  }

 private:
  struct ArmTicks {
    std::optional<TickWriter> writer = {};
    std::optional<TickWriter::Snapshot> snapshot = {};  ///< of the next period
    double snapshot_due = 0.0;                          ///< [s]
  };

  /// A recording has no more channels. Episodes that run at the same time are near each other and have different
  /// writers.
  static std::uint32_t writers_of(const planner::Cell& cell) {
    return static_cast<std::uint32_t>(std::max<std::size_t>(1, recorder::Recording::kMostChannels / cell.arms.size()));
  }

  void write(int arm, const std::string& name, const TickWriter& writer, double time) {
    recorder::RecordedSample recorded;
    recorded.sample.topic = topic_of_ticks();
    recorded.sample.bytes = bus::encode_recorded(writer.message());
    recorded.sample.key = name;
    std::memcpy(recorded.sample.writer.bytes.data(), &writer_, sizeof writer_);
    recorded.sample.writer.bytes.back() = static_cast<std::uint8_t>(arm);
    recorded.sample.number = writer.message().sequence_number();
    recorded.node = writer.message().node();
    recorded.log_time = nanoseconds_of(time);
    recording_.write(std::move(recorded));
  }

  SimulationRecording& recording_;
  std::uint32_t writer_;
  double begin_;  ///< [s]
  planner::SharedObstacles obstacles_;
  std::vector<std::string> names_;
  std::vector<ArmTicks> arms_;
};

SimulationRecording::SimulationRecording(const std::string& path, const config::CellFile& file,
                                         const CellChanges& changes)
    : recording_(begin(path, file, changes)) {}

std::function<void(const planner::PlannerPeriod&)> SimulationRecording::record_episode(int episode,
                                                                                       const planner::Cell& cell) {
  auto ticks = std::make_shared<EpisodeTicks>(*this, episode, cell);
  return [ticks](const planner::PlannerPeriod& period) { ticks->take(period); };
}

void SimulationRecording::write(recorder::RecordedSample sample) {
  const std::lock_guard lock(mutex_);
  if (failed_) return;
  if (sample.sample.bytes.empty()) {
    return fail("a tick of arm " + sample.sample.key + " breaks a rule of the wire");
  }
  try {
    recording_.write(std::move(sample));
  } catch (const recorder::RecordingError& error) {
    fail(error.what());
  }
}

void SimulationRecording::fail(const std::string& reason) {
  failure_ = "--record: " + reason;
  failed_ = true;
}

void SimulationRecording::finish() {
  if (failed_) throw Failure(ExitCode::kBadInput, failure_);
  try {
    recording_.close();
  } catch (const recorder::RecordingError& error) {
    throw Failure(ExitCode::kBadInput, std::string("--record: ") + error.what());
  }
}

}  // namespace hecaton::services::cli
