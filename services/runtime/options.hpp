#pragma once
/// The command line that all services share, and what every program of the project returns.

#include <functional>
#include <optional>
#include <string>

namespace CLI {
class App;
}

namespace hecaton::services {

enum class ExitCode : int {
  kDone = 0,
  kNegative = 1,  ///< the program ran and the outcome is negative
  kUsage = 2,     ///< no such command, option or choice, or one too many or too few
  kBadInput = 3,  ///< a value that is not allowed (option, file, environment): one sentence on stderr
  kTimeOut = 4,
  kUnreachable = 5,    ///< no such cell
  kNoMemory = 12,      ///< of a service (ENOMEM)
  kInterrupted = 130,  ///< by SIGINT; the output has what was done so far
  kTerminated = 143,   ///< the same by SIGTERM
};

inline constexpr int kHighestDomain = 199;  ///< above, ports of large domains exceed 65535

enum class LogLevel { kDebug, kInfo, kWarning, kError };

struct ServiceOptions {
  std::string cell;           ///< path of the cell file
  std::string arm;            ///< the arm that the service serves; empty for services of the whole cell
  std::optional<int> domain;  ///< DDS domain 0 to 199; otherwise HECATON_DOMAIN, otherwise the cell file's
  std::string host;           ///< the cell's host it runs on; empty: where the cell file places it
  std::string sources;        ///< folder with copies of the cell's files; empty: they are read where they are
  std::string checkpoint;     ///< file whose contents survive a restart of the service; empty: none
  int heartbeat_fd = -1;      ///< a socket on which the loop shows its agent that it runs; −1: none
  int exit_fd = -1;           ///< a pipe that closes when the process ends, see start_exit_notifier(); −1: none
  LogLevel log_level = LogLevel::kInfo;
  std::string log_file;  ///< empty: stderr
};

/// Adds --domain, --host, --log-level and --log-file to any command.
void add_common_options(CLI::App& app, ServiceOptions& options);

/// Parses the command line. Returns the exit code when the program shall not run on: after --help or --version, or
/// after a usage error, which it explains on stderr.
[[nodiscard]] std::optional<ExitCode> parse_or_explain(CLI::App& app, int argc, const char* const* argv);

/// Prints a sentence on stderr after the name with which the program was called, up to a blank: "hecaton: …" for a
/// program that `hecaton view` runs.
void complain(const std::string& sentence);

enum class Subject {
  kCell,  ///< the whole cell
  kArm,   ///< one arm
};

/// Adds the options of one service to its command line.
using MoreOptions = std::function<void(CLI::App&)>;

/// Parses a service's command line: CELL, --arm NAME for Subject::kArm, --checkpoint FILE, the common options, and
/// those that `more` adds. Returns as parse_or_explain().
[[nodiscard]] std::optional<ExitCode> parse_options(int argc, const char* const* argv, const std::string& description,
                                                    Subject subject, ServiceOptions& options,
                                                    const MoreOptions& more = {});

/// The DDS domain: the option, else HECATON_DOMAIN, else `of_cell`. Throws std::runtime_error with a sentence when
/// HECATON_DOMAIN is no number from 0 to 199.
[[nodiscard]] int choose_domain(const ServiceOptions& options, int of_cell);

}  // namespace hecaton::services
