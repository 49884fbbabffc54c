#include "services/supervisor/memory.hpp"

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

bool parse_unheard(std::istream& words, Orders& unheard) {
  std::string arm;
  std::string mode;
  words >> arm >> mode;
  const auto parsed = parse_mode(mode);
  if (!parsed) return false;
  (arm == kCell ? unheard.cell : unheard.arms[arm]) = *parsed;
  return true;
}

bool parse_line(const std::string& line, Memory& memory) {
  std::istringstream words(line);
  std::string kind;
  words >> kind;
  if (kind == "fault") return parse_fault(words, memory.faults);
  if (kind == "because") return parse_cause(words, memory.causes);
  if (kind == "unheard") return parse_unheard(words, memory.unheard);
  if (kind == "term") return static_cast<bool>(words >> memory.term);
  std::string arm;
  std::string mode;
  if (kind == "arm") words >> arm;
  words >> mode;
  const auto parsed = parse_mode(mode);
  if (!parsed || (kind != "arm" && kind != "cell")) return false;
  (kind == "cell" ? memory.orders.cell : memory.orders.arms[arm]) = *parsed;
  return true;
}

}  // namespace

std::string memory_text(const Memory& memory) {
  std::ostringstream text;
  text << "term " << memory.term << "\ncell " << mode_name(memory.orders.cell) << '\n';
  for (const auto& [arm, mode] : memory.orders.arms) text << "arm " << arm << ' ' << mode_name(mode) << '\n';
  for (const auto& [arm, cause] : memory.causes) {
    text << "because " << (arm.empty() ? kCell : arm) << ' ' << cause_name(cause.kind()) << ' ' << word(cause.subject())
         << ' ' << sentence(cause.text()) << '\n';
  }
  if (memory.unheard.cell != msg::Mode::MODE_RUN)
    text << "unheard " << kCell << ' ' << mode_name(memory.unheard.cell) << '\n';
  for (const auto& [arm, mode] : memory.unheard.arms) text << "unheard " << arm << ' ' << mode_name(mode) << '\n';
  for (const auto& [cause, record] : memory.faults.open) append_fault(text, record, cause);
  for (const FaultRecord& record : memory.faults.over) append_fault(text, record, {});
  return text.str();
}

std::optional<Memory> parse_memory(const std::string& text) {
  Memory memory;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && !parse_line(line, memory)) return std::nullopt;
  }
  if (memory.term == 0) return std::nullopt;
  return memory;
}

std::optional<Memory> read_memory(const std::string& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::ostringstream text;
  text << file.rdbuf();
  auto memory = parse_memory(text.str());
  if (!memory) throw std::runtime_error("--memory " + path + " is not what a supervisor wrote: remove or repair it");
  return memory;
}

std::string next_memory(const std::string& path) {
  return other_file_of(path);
}

std::string write_memory(const std::string& path, const Memory& memory) {
  return keep_in_file(path, memory_text(memory), '\n');
}

}  // namespace hecaton::services
