#pragma once
/// Structured log lines on stderr or in a file:
///   time=2026-01-31T12:00:00.000Z level=info node=planner/arm1 event="goal rejected" goal=g7 reason="joint 2 = …"
/// A separate thread writes the lines, so that no loop waits for the log. When it cannot keep up, the oldest lines are
/// dropped. Of an event that occurs very often most lines are left out, and the next one counts them (log_limit.hpp).

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "services/runtime/options.hpp"

namespace hecaton::services {

/// key=value of a log line.
struct LogField {
  LogField(std::string_view field_key, std::string_view field_value) : key(field_key), value(field_value) {}
  LogField(std::string_view field_key, const char* field_value) : key(field_key), value(field_value) {}
  LogField(std::string_view field_key, const std::string& field_value) : key(field_key), value(field_value) {}
  LogField(std::string_view field_key, bool field_value) : key(field_key), value(field_value ? "true" : "false") {}
  LogField(std::string_view field_key, double field_value);
  template <std::integral I>
  LogField(std::string_view field_key, I field_value) : key(field_key), value(std::to_string(field_value)) {}

  std::string_view key;
  std::string value;
};
using LogFields = std::initializer_list<LogField>;

/// Opens the log of this process; its destructor writes the remaining lines. Only one may exist at a time.
class LogScope {
 public:
  /// Throws std::runtime_error with a sentence when the file cannot be opened.
  LogScope(const std::string& node, const ServiceOptions& options);
  ~LogScope();
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;
};

/// Thread-safe. Without a LogScope they do nothing.
void log_debug(std::string_view event, LogFields fields = {});
void log_info(std::string_view event, LogFields fields = {});
void log_warning(std::string_view event, LogFields fields = {});
void log_error(std::string_view event, LogFields fields = {});

/// A line without time, level and node. Values with special characters are quoted.
[[nodiscard]] std::string log_text(std::string_view event, LogFields fields);

}  // namespace hecaton::services
