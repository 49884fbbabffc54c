#include "services/runtime/log.hpp"

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cstdio>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>

#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "services/runtime/log_limit.hpp"
#include "services/runtime/thread_priority.hpp"

namespace hecaton::services {
namespace {

constexpr std::size_t kQueue = 1024;  // lines

std::atomic<std::shared_ptr<spdlog::logger>>& current() {
  static std::atomic<std::shared_ptr<spdlog::logger>> logger;
  return logger;
}

spdlog::level::level_enum severity(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
    case LogLevel::kInfo:
      break;
  }
  return spdlog::level::info;
}

bool needs_quotes(std::string_view value) {
  return value.empty() || std::any_of(value.begin(), value.end(), [](char c) {
           return c == ' ' || c == '"' || c == '=' || c == '\\' || std::iscntrl(static_cast<unsigned char>(c)) != 0;
         });
}

void append(std::string& line, std::string_view key, std::string_view value) {
  if (!line.empty()) line += ' ';
  line += key;
  line += '=';
  if (!needs_quotes(value)) {
    line += value;
    return;
  }
  line += '"';
  for (const char c : value) {
    if (c == '"' || c == '\\') line += '\\';
    if (c == '\n') {
      line += "\\n";
    } else if (std::iscntrl(static_cast<unsigned char>(c)) == 0) {
      line += c;
    }
  }
  line += '"';
}

std::optional<std::uint64_t> admit(std::string_view event) {
  static std::mutex mutex;
  static LogLimit limit;
  const std::scoped_lock lock(mutex);
  return limit.admit(event, std::chrono::steady_clock::now());
}

void write(spdlog::level::level_enum level, std::string_view event, LogFields fields) {
  const auto logger = current().load();
  if (!logger || !logger->should_log(level)) return;
  std::string line = log_text(event, fields);
  if (level > spdlog::level::debug) {  // debugging wants all lines
    const auto omitted = admit(event);
    if (!omitted) return;
    if (*omitted > 0) append(line, "omitted_before", std::to_string(*omitted));
  }
  logger->log(level, line);
}

}  // namespace

LogField::LogField(std::string_view field_key, double field_value) : key(field_key) {
  char text[32];
  const int length = std::snprintf(text, sizeof text, "%.6g", field_value);
  value.assign(text, static_cast<std::size_t>(std::max(length, 0)));
}

LogScope::LogScope(const std::string& node, const ServiceOptions& options) {
  spdlog::init_thread_pool(kQueue, 1, keep_startup_priority);
  spdlog::sink_ptr sink;
  if (options.log_file.empty()) {
    sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
  } else {
    try {
      sink = std::make_shared<spdlog::sinks::basic_file_sink_mt>(options.log_file);
    } catch (const spdlog::spdlog_ex&) {
      throw std::runtime_error("--log-file " + options.log_file + " cannot be opened for writing");
    }
  }
  auto logger = std::make_shared<spdlog::async_logger>(node, std::move(sink), spdlog::thread_pool(),
                                                       spdlog::async_overflow_policy::overrun_oldest);
  logger->set_level(severity(options.log_level));
  logger->flush_on(spdlog::level::info);
  logger->set_formatter(std::make_unique<spdlog::pattern_formatter>("time=%Y-%m-%dT%H:%M:%S.%eZ level=%l node=%n %v",
                                                                    spdlog::pattern_time_type::utc));
  current().store(std::move(logger));
}

LogScope::~LogScope() {
  const auto logger = current().exchange(nullptr);  // keeps it until its thread has ended
  spdlog::shutdown();
}

void log_debug(std::string_view event, LogFields fields) {
  write(spdlog::level::debug, event, fields);
}
void log_info(std::string_view event, LogFields fields) {
  write(spdlog::level::info, event, fields);
}
void log_warning(std::string_view event, LogFields fields) {
  write(spdlog::level::warn, event, fields);
}
void log_error(std::string_view event, LogFields fields) {
  write(spdlog::level::err, event, fields);
}

std::string log_text(std::string_view event, LogFields fields) {
  std::string line;
  append(line, "event", event);
  for (const LogField& field : fields) append(line, field.key, field.value);
  return line;
}

}  // namespace hecaton::services
