#include "services/supervisor/replication/checkpoint.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "services/bus/wire_rules.hpp"
#include "services/runtime/atomic_file.hpp"

namespace hecaton::services {
namespace {

std::optional<msg::Mode> parse_mode(const std::string& name) {
  for (const msg::Mode mode : {msg::Mode::MODE_RUN, msg::Mode::MODE_HOLD, msg::Mode::MODE_STOP}) {
    if (mode_name(mode) == name) return mode;
  }
  return std::nullopt;
}

constexpr std::chrono::nanoseconds kUnknown{-1};
const std::string kCell = "/";  // not allowed as an arm's name

/// `text` as one word of a line. Texts of other supervisors' faults may contain anything.
std::string word(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::isspace(c) != 0; }, '_');
  return text.empty() ? "?" : text;
}

/// `text` as the rest of a line.
std::string sentence(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::isspace(c) != 0; }, ' ');
  return text.find_first_not_of(' ') == std::string::npos ? "?" : text;
}

/// `key`: of an open fault.
void append_fault(std::ostream& text, const FaultRecord& record, const std::string& key) {
  text << "fault " << record.opening_term << ' ' << record.number << ' ' << cause_name(record.kind) << ' '
       << static_cast<int>(record.severity) << ' ' << record.since.count() << ' '
       << record.detection_latency_bound.value_or(kUnknown).count() << ' ';
  if (record.cleared_at) {
    text << record.cleared_at->count() << " - ";
  } else {
    text << "open " << word(key) << ' ';
  }
  text << word(record.subject) << ' ' << sentence(record.description) << '\n';
}

bool parse_fault(std::istream& words, FaultHistory& faults) {
  FaultRecord record;
  std::string kind;
  std::string cleared;
  std::string key;
  int severity = -1;
  std::chrono::nanoseconds::rep since = 0;
  std::chrono::nanoseconds::rep latency_bound = 0;
  words >> record.opening_term >> record.number >> kind >> severity >> since >> latency_bound >> cleared >> key >>
      record.subject >> std::ws;
  std::getline(words, record.description);
  const auto known = cause_kind(kind);
  if (!words || !known || !is_fault(*known) || severity < 0 ||
      severity > static_cast<int>(msg::Severity::SEVERITY_CRITICAL))
    return false;
  record.kind = *known;
  record.severity = static_cast<msg::Severity>(severity);
  record.since = std::chrono::nanoseconds(since);
  if (latency_bound >= 0) record.detection_latency_bound = std::chrono::nanoseconds(latency_bound);
  if (cleared == "open") {
    faults.open[key] = record;
    return true;
  }
  std::chrono::nanoseconds::rep end = 0;
  if (!(std::istringstream(cleared) >> end)) return false;
  record.cleared_at = std::chrono::nanoseconds(end);
  faults.cleared.push_back(record);
  return true;
}

bool parse_cause(std::istream& words, CausesByArm& causes) {
  std::string arm;
  std::string kind;
  std::string subject;
  std::string text;
  words >> arm >> kind >> subject >> std::ws;
  std::getline(words, text);
  const auto known = cause_kind(kind);
  if (!words || !known) return false;
  causes[arm == kCell ? std::string() : arm] = make_cause(*known, subject, text);
  return true;
}

bool parse_unreplicated(std::istream& words, Orders& unreplicated) {
  std::string arm;
  std::string mode;
  words >> arm >> mode;
  const auto parsed = parse_mode(mode);
  if (!parsed) return false;
  (arm == kCell ? unreplicated.cell : unreplicated.arms[arm]) = *parsed;
  return true;
}

void append_speeds(std::ostream& text, const char* kind, const Orders& orders) {
  constexpr int kExact = 17;  // digits of a double
  const auto line = [&](const std::string& name, double speed) {
    text << kind << ' ' << name << ' ' << std::setprecision(kExact) << speed << '\n';
  };
  if (orders.speed < kFullSpeed) line(kCell, orders.speed);
  for (const auto& [arm, speed] : orders.speeds) line(arm, speed);
}

bool parse_speed(std::istream& words, Orders& orders) {
  std::string arm;
  double speed = 0.0;
  if (!(words >> arm >> speed) || !(speed >= kSlowestSpeed && speed < kFullSpeed)) return false;
  (arm == kCell ? orders.speed : orders.speeds[arm]) = speed;
  return true;
}

bool parse_line(const std::string& line, Checkpoint& checkpoint) {
  std::istringstream words(line);
  std::string kind;
  words >> kind;
  if (kind == "fault") return parse_fault(words, checkpoint.faults);
  if (kind == "because") return parse_cause(words, checkpoint.causes);
  if (kind == "unreplicated") return parse_unreplicated(words, checkpoint.unreplicated);
  if (kind == "speed") return parse_speed(words, checkpoint.orders);
  if (kind == "unreplicated_speed") return parse_speed(words, checkpoint.unreplicated);
  if (kind == "term") return static_cast<bool>(words >> checkpoint.term);
  std::string arm;
  std::string mode;
  if (kind == "arm") words >> arm;
  words >> mode;
  const auto parsed = parse_mode(mode);
  if (!parsed || (kind != "arm" && kind != "cell")) return false;
  (kind == "cell" ? checkpoint.orders.cell : checkpoint.orders.arms[arm]) = *parsed;
  return true;
}

}  // namespace

std::string checkpoint_text(const Checkpoint& checkpoint) {
  std::ostringstream text;
  text << "term " << checkpoint.term << "\ncell " << mode_name(checkpoint.orders.cell) << '\n';
  for (const auto& [arm, mode] : checkpoint.orders.arms) text << "arm " << arm << ' ' << mode_name(mode) << '\n';
  for (const auto& [arm, cause] : checkpoint.causes) {
    text << "because " << (arm.empty() ? kCell : arm) << ' ' << cause_name(cause.kind()) << ' ' << word(cause.subject())
         << ' ' << sentence(cause.text()) << '\n';
  }
  if (checkpoint.unreplicated.cell != msg::Mode::MODE_RUN)
    text << "unreplicated " << kCell << ' ' << mode_name(checkpoint.unreplicated.cell) << '\n';
  for (const auto& [arm, mode] : checkpoint.unreplicated.arms)
    text << "unreplicated " << arm << ' ' << mode_name(mode) << '\n';
  append_speeds(text, "speed", checkpoint.orders);
  append_speeds(text, "unreplicated_speed", checkpoint.unreplicated);
  for (const auto& [key, record] : checkpoint.faults.open) append_fault(text, record, key);
  for (const FaultRecord& record : checkpoint.faults.cleared) append_fault(text, record, {});
  return text.str();
}

std::optional<Checkpoint> parse_checkpoint(const std::string& text) {
  Checkpoint checkpoint;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && !parse_line(line, checkpoint)) return std::nullopt;
  }
  if (checkpoint.term == 0 || !bus::is_usable_term(checkpoint.term)) return std::nullopt;
  return checkpoint;
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  auto checkpoint = parse_checkpoint(text.str());
  if (!checkpoint)
    throw std::runtime_error("--checkpoint " + path + " is no checkpoint of a supervisor: remove or repair it");
  return checkpoint;
}

CheckpointFile::CheckpointFile(std::string path) : path_(std::move(path)) {
  if (path_.empty()) return;
  try {
    if (auto checkpoint = read_checkpoint(path_)) stored_ = *std::move(checkpoint);
  } catch (const std::runtime_error&) {
    const std::string aside = path_ + ".unusable";
    std::error_code failed;
    std::filesystem::rename(path_, aside, failed);
    lost_ = "the checkpoint of the earlier process cannot be used, and its orders are unknown; it is now " + aside;
  }
}

std::optional<std::string> write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  return write_atomically(path, checkpoint_text(checkpoint), '\n');
}

}  // namespace hecaton::services
