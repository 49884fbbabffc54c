#pragma once
/// A client of the dashboard server (port 29999) of CB3 and PolyScope 5: one text command, one line as its answer.

#include <chrono>
#include <deque>
#include <optional>
#include <string>

#include "services/arm_driver/devices/universal_robots/tcp.hpp"

namespace hecaton::device::universal_robots {

/// Connects again, at most once a second, when the connection closes, and after 8 s without an answer. No call waits.
/// For one thread.
class Dashboard {
 public:
  struct Answer {
    std::string command;
    std::string text;  ///< without the end of the line
  };

  void open(const std::string& address, Clock::time_point now);
  /// It stays closed until open().
  void close();
  /// Call it once a period.
  void update(Clock::time_point now);

  /// The robot has greeted.
  [[nodiscard]] bool is_open() const { return greeted_ && connection_.is_open(); }
  /// It has greeted since open(), perhaps on an earlier connection.
  [[nodiscard]] bool has_greeted() const { return has_greeted_; }
  /// No command waits for its answer.
  [[nodiscard]] bool is_idle() const { return commands_.empty(); }
  /// Sends a command after those before it were answered. Precondition: is_open().
  void send(const std::string& command, Clock::time_point now);
  /// The next answer; empty: none. When the connection fails, commands get none.
  [[nodiscard]] std::optional<Answer> take();

 private:
  void connect(Clock::time_point now);
  void drop();
  void send_next(Clock::time_point now);

  std::string address_;  ///< empty before open()
  TcpConnection connection_;
  bool greeted_ = false;  ///< on this connection
  bool has_greeted_ = false;
  bool asked_ = false;                ///< the first of commands_ was sent
  std::deque<std::string> commands_;  ///< not answered yet
  std::deque<Answer> answers_;
  Clock::time_point deadline_;  ///< of the greeting, then of each answer
  Clock::time_point reopen_at_;
};

}  // namespace hecaton::device::universal_robots
