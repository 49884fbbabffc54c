#include "services/simulation_recording/simulation_recording.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "services/recorder/losses.hpp"
#include "services/recorder/recorder.hpp"
#include "services/runtime/node_name.hpp"
#include "services/simulation_recording/episode_messages.hpp"

namespace hecaton::services {
namespace {

recorder::Recording begin_file(const std::string& path, const config::CellFile& file, const CellChanges& changes) {
  std::vector<recorder::AttachedFile> attached = recorder::attachments_of(file);
  attached.push_back({std::string(recorder::Recording::kSimulation), "application/json", changes.json()});
  return recorder::Recording({.path = path}, std::move(attached), 0);
}

}  // namespace

class SimulationRecording::Episode : public planner::EpisodeLog {
 public:
  Episode(SimulationRecording& recording, int episode, const planner::Cell& cell)
      : recording_(recording), episode_(episode), messages_(recording.file_, cell, episode) {}

  void begin(const planner::CellConfiguration& goals) override { messages_.begin(goals); }
  void publish(const planner::CellMoment& moment) override {
    messages_.publish(moment);
    pass_on();
  }
  void plan(const planner::PlannerPeriod& period) override { messages_.plan(period); }
  void end(const planner::EpisodeOutcome& outcome) override {
    messages_.end(outcome);
    pass_on();
  }

 private:
  void pass_on() { recording_.take(episode_, messages_.take()); }

  SimulationRecording& recording_;
  int episode_;
  EpisodeMessages messages_;
};

SimulationRecording::SimulationRecording(const std::string& path, const config::CellFile& file,
                                         const CellChanges& changes)
    : file_(file), recording_(begin_file(path, file, changes)) {}

SimulationRecording::~SimulationRecording() = default;

std::unique_ptr<planner::EpisodeLog> SimulationRecording::begin(int episode, const planner::Cell& cell) {
  return std::make_unique<Episode>(*this, episode, cell);
}

void SimulationRecording::take(int episode, Samples samples) {
  const std::lock_guard lock(mutex_);
  if (failed_) return;
  if (episode == written_) return write_all(std::move(samples));
  Samples& waiting = waiting_[episode].samples;
  std::move(samples.begin(), samples.end(), std::back_inserter(waiting));
}

void SimulationRecording::end(int episode) {
  const std::lock_guard lock(mutex_);
  waiting_[episode].ended = true;
  for (auto next = waiting_.find(written_); next != waiting_.end() && next->second.ended;
       next = waiting_.find(written_)) {
    waiting_.erase(next);
    ++written_;
    if (std::exchange(begun_, false)) {
      began_ = last_ + static_cast<std::uint64_t>(std::llround(file_.cell.timing.control_period * 1e9));
    }
    const auto successor = waiting_.find(written_);
    if (successor != waiting_.end()) write_all(std::exchange(successor->second.samples, {}));
  }
}

void SimulationRecording::write_all(Samples samples) {
  if (failed_ || samples.empty()) return;
  begun_ = true;
  for (recorder::RecordedSample& sample : samples) write(std::move(sample));
}

void SimulationRecording::write(recorder::RecordedSample sample) {
  if (failed_) return;
  const bus::TopicInfo& topic = bus::kTopics[sample.sample.topic];
  if (sample.sample.bytes.empty()) {
    return fail("a sample of " + std::string(topic.name) + " for '" + sample.sample.key +
                "' breaks a rule of the wire");
  }
  sample.log_time += began_;
  last_ = std::max(last_, sample.log_time);
  sample.sample.number = ++numbers_[sample.sample.writer];
  ++counts_[sample.sample.topic];
  if (topic.type == "PlannerTick") ++ticks_;
  try {
    recording_.write(std::move(sample));
  } catch (const recorder::RecordingError& error) {
    fail(error.what());
  }
}

void SimulationRecording::fail(const std::string& reason) {
  failure_ = reason;
  failed_ = true;
}

void SimulationRecording::write_report() {
  nlohmann::ordered_json json{
      {"cell", file_.cell.name}, {"began_ns", 0}, {"duration_s", static_cast<double>(last_) * 1e-9}};
  for (const auto& [topic, count] : counts_) {
    recorder::TopicLosses figures;
    figures.received = count;
    json["topics"][std::string(bus::kTopics[topic].name)] = figures.fields();
  }
  recording_.report(json.dump(), last_);
}

void SimulationRecording::finish() {
  const std::lock_guard lock(mutex_);
  if (failed_) throw recorder::RecordingError(failure_);
  write_report();
  recording_.close();
}

}  // namespace hecaton::services
