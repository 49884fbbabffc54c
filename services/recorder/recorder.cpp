#include "services/recorder/recorder.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include <idl/health.h>
#include <nlohmann/json.hpp>

#include "services/bus/recorded_sample.hpp"
#include "services/bus/wire_rules.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/temporary_folder.hpp"
#include "services/view/arm_drawing.hpp"

namespace hecaton::services::recorder {
namespace {

using namespace std::chrono_literals;

constexpr auto kReportPeriod = 1s;
constexpr std::size_t kMostNodes = 65536;
constexpr std::uintmax_t kLargestAttachment = std::uintmax_t{16} << 20U;

std::string media_type(const std::filesystem::path& file) {
  const std::string extension = file.extension().string();
  if (extension == ".yaml" || extension == ".yml") return std::string(kYamlFile);
  if (extension == ".urdf" || extension == ".xacro" || extension == ".srdf" || extension == ".xml") {
    return "application/xml";
  }
  return "application/octet-stream";
}

template <class Id>
Id participant_of(const bus::EndpointId& endpoint) {
  Id id{};
  std::copy_n(endpoint.bytes.begin(), id.size(), id.begin());
  return id;
}

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Adds the meshes with which an arm is drawn, if all of them fit into `left`, which becomes less.
void attach_meshes(const view::ArmDrawing& drawing, const std::string& arm, std::vector<AttachedFile>& attached,
                   std::uintmax_t& left) {
  std::vector<std::string> missing;
  std::uintmax_t bytes = 0;
  for (const std::filesystem::path& file : drawing.files) {
    const std::string path = std::filesystem::absolute(file).lexically_normal().string();
    const auto known = [&](const AttachedFile& other) { return other.name == path; };
    if (std::any_of(attached.begin(), attached.end(), known)) continue;
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file, error);
    if (error) continue;  // it cannot be drawn now, either
    missing.push_back(path);
    bytes += size;
  }
  if (bytes > left) {
    log_warning("the meshes of an arm are not in the recording", {{"arm", arm}, {"bytes", bytes}, {"left", left}});
    return;
  }
  left -= bytes;
  for (const std::string& path : missing) attached.push_back({path, media_type(path), text_of(path)});
}

/// A file of a row has a copy of its own: they take a hundredth of the place for all files.
std::uintmax_t most_meshes_of(const RecordingOptions& recording) {
  return recording.most_bytes > 0 ? std::min<std::uintmax_t>(kMostMeshes, recording.most_bytes / 100) : kMostMeshes;
}

}  // namespace

std::vector<AttachedFile> attachments_of(const config::CellFile& file, std::uintmax_t most_meshes) {
  const TemporaryFolder copies;
  file.sources.keep(copies.path());
  const std::string cell = std::filesystem::absolute(file.path).lexically_normal().string();
  std::vector<AttachedFile> attached;
  for (const std::string& path : file.sources.read()) {
    const std::filesystem::path copy = copies.path() / std::filesystem::path(path).relative_path();
    std::error_code error;
    const std::uintmax_t bytes = std::filesystem::file_size(copy, error);
    if (error || bytes > kLargestAttachment) {
      log_warning("a file of the cell is not in the recording",
                  {{"file", path}, {"why", error ? error.message() : "more than 16 MiB"}});
      continue;
    }
    const auto place = path == cell ? attached.begin() : attached.end();
    attached.insert(place, {path, media_type(path), text_of(copy)});
  }
  const view::Drawings drawings(file);
  for (std::size_t i = 0; i < drawings.arms().size(); ++i) {
    attach_meshes(drawings.arms()[i], file.cell.arms[i].arm.name, attached, most_meshes);
  }
  return attached;
}

Recorder::Recorder(const config::CellFile& file, bus::Participant& participant, bus::Mailbox& mailbox,
                   const RecordingOptions& recording)
    : file_(file),
      clock_offset_(std::chrono::system_clock::now().time_since_epoch() - bus::Clock::now().time_since_epoch()),
      mailbox_(mailbox),
      recording_(recording, attachments_of(file, most_meshes_of(recording)), unix_time(began_)),
      readers_(participant, mailbox, kMostWaiting) {
  if (recording.ros2) ros2_.emplace(file, recording_, unix_time(began_));
}

std::uint64_t Recorder::unix_time(bus::Clock::time_point time) const {
  return static_cast<std::uint64_t>((time.time_since_epoch() + clock_offset_).count());
}

void Recorder::take() {
  receive();
  if (ros2_) ros2_->write_due(unix_time(bus::Clock::now()));
  recording_.keep_up(unix_time(bus::Clock::now()));
}

void Recorder::close() {
  receive();
  report_at_ = {};
  report();
  recording_.close();
}

void Recorder::receive() {
  std::vector<bus::RawSample> samples = readers_.take();
  // Discovery has found the writer of a sample before the sample came.
  for (const bus::Event& event : mailbox_.take_events()) {
    if (event.kind != bus::EventKind::kParticipantFound || nodes_.size() >= kMostNodes) continue;
    nodes_[participant_of<ParticipantId>(event.peer)] = bus::printable(event.key, bus::kLongestName);
  }
  for (bus::RawSample& sample : samples) {
    losses_.note(sample);
    note_clock(sample);
    RecordedSample recorded;
    recorded.log_time = unix_time(sample.received);
    const auto node = nodes_.find(participant_of<ParticipantId>(sample.writer));
    if (node != nodes_.end()) recorded.node = node->second;
    recorded.sample = std::move(sample);
    if (ros2_) ros2_->take(recorded);
    recording_.write(std::move(recorded));
  }
  report();
}

void Recorder::note_clock(const bus::RawSample& sample) {
  if (bus::kTopics[sample.topic].name != bus::Topic<msg::Heartbeat>::kInfo.name) return;
  if (sample.withdrawn || sample.written_ns <= 0) return;
  const auto heartbeat = bus::decode_recorded<msg::Heartbeat>(sample.bytes);
  if (!heartbeat.value) return;
  clocks_.note(heartbeat.value->host(), unix_time(sample.received), static_cast<std::uint64_t>(sample.written_ns),
               heartbeat.value->stamp_ns());
}

void Recorder::report() {
  const auto now = bus::Clock::now();
  if (now < report_at_) return;
  report_at_ = now + kReportPeriod;
  report_losses(now);
  report_clocks(now);
}

void Recorder::report_losses(bus::Clock::time_point now) {
  std::vector<TopicLosses> losses = losses_.losses(readers_.counters());
  if (losses == reported_) return;
  reported_ = std::move(losses);
  nlohmann::ordered_json json{{"cell", file_.cell.name},
                              {"began_ns", unix_time(began_)},
                              {"duration_s", std::chrono::duration<double>(now - began_).count()}};
  for (std::size_t i = 0; i < reported_.size(); ++i) {
    json["topics"][std::string(bus::kTopics[i].name)] = reported_[i].fields();
  }
  recording_.report(json.dump(), unix_time(now));
}

void Recorder::report_clocks(bus::Clock::time_point now) {
  nlohmann::ordered_json hosts = nlohmann::ordered_json::object();
  for (const auto& [host, clock] : clocks_.take()) {
    hosts[host] = {{"heartbeats", clock.samples},
                   {"log_minus_publish_ns", clock.log_minus_publish},
                   {"log_minus_stamp_ns", clock.log_minus_stamp}};
  }
  if (!hosts.empty()) recording_.compare_clocks(nlohmann::ordered_json{{"hosts", hosts}}.dump(), unix_time(now));
}

}  // namespace hecaton::services::recorder
