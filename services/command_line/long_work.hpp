#pragma once
/// Work that takes seconds or hours: its progress on a terminal, and its early end by a signal, which keeps what is
/// done.

#include <chrono>
#include <cstdio>
#include <mutex>
#include <optional>
#include <string>

#include "services/command_line/document.hpp"
#include "services/runtime/options.hpp"

namespace hecaton::services::cli {

/// How much of its work a command had done when a signal ended it.
struct Interrupted {
  int signal = 0;    ///< SIGINT or SIGTERM
  Json done = 0;     ///< a number of `unit`
  Json asked = 0;    ///< a number of `unit`
  std::string unit;  ///< of both: "tasks", "strategies", "s"

  /// "interrupted by SIGINT: 12 of 100 tasks done"
  [[nodiscard]] std::string text() const;
  /// 130 for SIGINT, 143 for SIGTERM, as shells count.
  [[nodiscard]] ExitCode exit_code() const;
};

/// The member `interrupted` of a report; null for complete work.
[[nodiscard]] Json to_json(const std::optional<Interrupted>& interrupted);

/// While it exists, the first SIGINT or SIGTERM only asks the work to end. A second one ends the process at once, with
/// exit code 128 + signal; repetitions within 200 ms count as the first, because `timeout` signals a program and then
/// its group. A signal that the process ignores stays ignored. At most one object at a time.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// Thread-safe.
  [[nodiscard]] bool requested() const { return signal() != 0; }
  /// The first signal; 0 before it. Thread-safe.
  [[nodiscard]] int signal() const;
  /// Empty before the first signal.
  [[nodiscard]] std::optional<Interrupted> after(Json done, Json asked, std::string unit) const;
};

/// One line on a terminal that is rewritten in place: what runs, how much of it is done, and the time left. Draws
/// nothing on any other stream, and nothing in the first half second of a piece of work. Thread-safe.
class Progress {
 public:
  /// On a stream that is no terminal.
  enum class Elsewhere {
    kNothing,
    kLines,  ///< a line every 5 s, as under mpirun
  };
  explicit Progress(Elsewhere elsewhere = Elsewhere::kNothing, std::FILE* stream = stderr);
  /// Clears the line.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// `done` of `all` `unit` of the work `what`; draws at most five times a second. Another `what` begins another piece
  /// of work. The time left follows from the speed since its beginning. `note`: further words, which a narrow
  /// terminal may cut; may be empty.
  void show(const std::string& what, double done, double all, const std::string& unit, const std::string& note = {});
  /// Before other output to the stream.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  std::FILE* stream_;
  bool terminal_;
  Elsewhere elsewhere_;
  std::mutex mutex_;
  std::string what_;
  double done_at_beginning_ = 0.0;
  Clock::time_point began_;
  Clock::time_point drawn_;
  bool visible_ = false;
};

}  // namespace hecaton::services::cli
