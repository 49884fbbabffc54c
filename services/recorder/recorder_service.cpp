#include "services/recorder/recorder_service.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>

#include <sys/stat.h>

#include "services/recorder/save_signal.hpp"
#include "services/runtime/cause.hpp"
#include "services/runtime/join.hpp"
#include "services/runtime/log.hpp"
#include "services/runtime/node_name.hpp"

namespace hecaton::services::recorder {
namespace {

using namespace std::chrono_literals;

constexpr auto kBeginPeriod = 10s;
const std::string kCell = "the cell";  // no name of an arm has a space

/// "cell-20261128T065430Z.mcap" in `folder`.
std::string row_path(const std::string& folder, const std::string& cell) {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> stamp{};
  std::strftime(stamp.data(), stamp.size(), "-%Y%m%dT%H%M%SZ.mcap", &utc);
  return folder + "/" + cell + stamp.data();
}

/// Throws RecordingError. Only the folder itself is made: a folder above that is missing is a disk that is not there.
void make_folder(const std::string& folder) {
  if (mkdir(folder.c_str(), S_IRWXU) == 0 || errno == EEXIST) return;
  throw RecordingError("folder " + folder + " cannot be made: " + std::strerror(errno));
}

/// The arms that people have stopped; kCell: the cell.
std::set<std::string> stopped_by_order(const msg::CellMode& mode) {
  std::set<std::string> stopped;
  if (mode.ordered() == msg::Mode::MODE_STOP) stopped.insert(kCell);
  for (const msg::ArmOrder& order : mode.arms()) {
    if (order.ordered() == msg::Mode::MODE_STOP) stopped.insert(order.arm());
  }
  return stopped;
}

}  // namespace

SavingEvents::SavingEvents(bus::Participant& participant) : faults_(participant), modes_(participant) {}

std::string SavingEvents::take() {
  std::string event;
  for (const auto& sample : faults_.take()) {
    const msg::Fault& fault = sample.value;
    if (sample.disposed || fault.cleared() || fault.severity() < msg::Severity::SEVERITY_ERROR) continue;
    event = "fault " + std::string(cause_name(fault.cause().kind())) + ": " + fault.cause().text();
  }
  if (modes_.update()) {
    std::set<std::string> stopped = stopped_by_order(modes_.view().mode());
    for (const std::string& subject : stopped) {
      if (!stopped_.contains(subject)) event = "a person ordered a stop of " + subject;
    }
    stopped_ = std::move(stopped);
  }
  if (SaveSignal::take()) event = kOrdered;
  return event;
}

RecordingOptions row_of(const config::Record& record, std::string path) {
  RecordingOptions options;
  options.path = std::move(path);
  options.split_bytes = record.split_size > 0 ? record.split_size : record.limit / 10;
  options.split_time = record.split_time;
  options.keep = record.keep;
  options.most_bytes = record.limit;
  options.ros2 = record.ros2;
  return options;
}

RecorderService::RecorderService(const config::CellFile& file, const ServiceOptions& options,
                                 const ShutdownSignal& shutdown)
    : file_(file),
      record_(file.record.value()),
      participant_(make_participant(file, options, Role::kViewer, recorder_node())),
      recording_participant_(make_participant(file, options, Role::kViewer, recorder_node(), &mailbox_)),
      loop_(std::min<std::chrono::nanoseconds>(Recorder::kPeriod, file.supervision.heartbeat_period), shutdown),
      events_(participant_),
      orders_(participant_, record_.host) {
  if (options.heartbeat_fd >= 0) {
    const NodeIdentity identity{recorder_node(), msg::NodeKind::NODE_OTHER, "", record_.host};
    heartbeat_.emplace(participant_, identity, heartbeat_timing(file, options));
  }
}

void RecorderService::run() {
  while (loop_.next()) {
    if (!recorder_) begin(loop_.now());
    std::string event = events_.take();
    const bool ordered = orders_.take();
    if (ordered) event = kOrdered;
    if (recorder_) record(event);
    if (ordered) orders_.reply(recorder_ ? newest_file() : "", refusal_.value_or(""));
    if (heartbeat_ && heartbeat_->due(loop_.now(), loop_.period() / 2)) publish_heartbeat();
  }
  if (!recorder_) return;
  try {
    recorder_->close();
  } catch (const RecordingError& error) {
    fail(error.what());
  }
}

void RecorderService::begin(bus::Clock::time_point now) {
  if (now < begin_at_) return;
  begin_at_ = now + kBeginPeriod;
  RecordingOptions options = row_of(record_, row_path(record_.folder, file_.cell.name));
  try {
    make_folder(record_.folder);
    options.former = former_files(options.path, file_.cell.name);
    recorder_ = std::make_unique<Recorder>(file_, recording_participant_, mailbox_, options);
    log_info("recording", {{"file", recorder_->recording().files().back()}});
    refusal_.reset();
  } catch (const RecordingError& error) {
    fail(error.what());
  }
}

void RecorderService::record(const std::string& event) {
  try {
    if (!event.empty()) {
      recorder_->save(record_.after_fault);
      log_info("recording saved", {{"because", event}});
    }
    recorder_->take();
  } catch (const RecordingError& error) {
    recorder_.reset();
    fail(error.what());
  }
}

std::string RecorderService::newest_file() const {
  return std::filesystem::absolute(recorder_->recording().files().back()).lexically_normal().string();
}

void RecorderService::fail(const std::string& reason) {
  if (!refusal_) log_error("the cell is not recorded", {{"reason", reason}});
  refusal_ = "the cell is not recorded: " + reason;
}

void RecorderService::publish_heartbeat() {
  HealthReport report;
  report.term = events_.term();
  if (refusal_) {
    report.state = msg::NodeState::NODE_FAILED;
    report.cause = make_cause(msg::CauseKind::CAUSE_NOT_ALLOWED_NOW, recorder_node(), *refusal_);
  }
  heartbeat_->publish(loop_.now(), report, loop_.statistics());
}

}  // namespace hecaton::services::recorder
