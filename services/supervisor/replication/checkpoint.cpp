#include "services/supervisor/replication/checkpoint.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "services/runtime/kept_file.hpp"

namespace hecaton::services {
namespace {

std::optional<msg::Mode> parse_mode(const std::string& name) {
  for (const msg::Mode mode : {msg::Mode::MODE_RUN, msg::Mode::MODE_HOLD, msg::Mode::MODE_STOP}) {
    if (mode_name(mode) == name) return mode;
  }
  return std::nullopt;
}

constexpr std::chrono::nanoseconds kUnknown{-1};
const std::string kCell = "/";  // no arm's name

/// As one word of a line, whatever somebody told: another supervisor's faults are remembered, too.
std::string word(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::isspace(c) != 0; }, '_');
  return text.empty() ? "?" : text;
}

/// As the rest of a line.
std::string sentence(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return std::isspace(c) != 0; }, ' ');
  return text.find_first_not_of(' ') == std::string::npos ? "?" : text;
}

/// `cause`: of an open fault.
void append_fault(std::ostream& text, const FaultRecord& record, const std::string& cause) {
  text << "fault " << record.life << ' ' << record.number << ' ' << cause_name(record.kind) << ' '
       << static_cast<int>(record.severity) << ' ' << record.since.count() << ' '
       << record.detected_within.value_or(kUnknown).count() << ' ';
  if (record.cleared) {
    text << record.cleared->count() << " - ";
  } else {
    text << "open " << word(cause) << ' ';
  }
  text << word(record.subject) << ' ' << sentence(record.seen) << '\n';
}

bool parse_fault(std::istream& words, FaultHistory& faults) {
  FaultRecord record;
  std::string kind;
  std::string cleared;
  std::string cause;
  int severity = -1;
  std::chrono::nanoseconds::rep since = 0;
  std::chrono::nanoseconds::rep within = 0;
  words >> record.life >> record.number >> kind >> severity >> since >> within >> cleared >> cause >> record.subject >>
      std::ws;
  std::getline(words, record.seen);
  const auto known = cause_kind(kind);
  if (!words || !known || !is_fault(*known) || severity < 0 ||
      severity > static_cast<int>(msg::Severity::SEVERITY_CRITICAL))
    return false;
  record.kind = *known;
  record.severity = static_cast<msg::Severity>(severity);
  record.since = std::chrono::nanoseconds(since);
  if (within >= 0) record.detected_within = std::chrono::nanoseconds(within);
  if (cleared == "open") {
    faults.open[cause] = record;
    return true;
  }
  std::chrono::nanoseconds::rep end = 0;
  if (!(std::istringstream(cleared) >> end)) return false;
  record.cleared = std::chrono::nanoseconds(end);
  faults.over.push_back(record);
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

bool parse_line(const std::string& line, Checkpoint& checkpoint) {
  std::istringstream words(line);
  std::string kind;
  words >> kind;
  if (kind == "fault") return parse_fault(words, checkpoint.faults);
  if (kind == "because") return parse_cause(words, checkpoint.causes);
  if (kind == "unreplicated") return parse_unreplicated(words, checkpoint.unreplicated);
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
  for (const auto& [cause, record] : checkpoint.faults.open) append_fault(text, record, cause);
  for (const FaultRecord& record : checkpoint.faults.over) append_fault(text, record, {});
  return text.str();
}

std::optional<Checkpoint> parse_checkpoint(const std::string& text) {
  Checkpoint checkpoint;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && !parse_line(line, checkpoint)) return std::nullopt;
  }
  if (checkpoint.term == 0) return std::nullopt;
  return checkpoint;
}

std::optional<Checkpoint> read_checkpoint(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  auto checkpoint = parse_checkpoint(text.str());
  if (!checkpoint)
    throw std::runtime_error("--memory " + path + " is not what a supervisor wrote: remove or repair it");
  return checkpoint;
}

std::string other_checkpoint(const std::string& path) {
  return other_file_of(path);
}

std::string write_checkpoint(const std::string& path, const Checkpoint& checkpoint) {
  return keep_in_file(path, checkpoint_text(checkpoint), '\n');
}

}  // namespace hecaton::services
