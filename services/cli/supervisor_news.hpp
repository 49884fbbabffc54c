#pragma once
/// What becomes of the supervisors themselves: the one that leads cannot tell its own death. From the agents' events
/// and the answers.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <idl/health.h>
#include <idl/supervisor.h>

#include "services/client/connection.hpp"

namespace hecaton::services::cli {

/// The same without a network: time is an argument.
class SupervisorStory {
 public:
  /// An event of any process. Empty, or a line to tell. What happened before the first answer is history.
  [[nodiscard]] std::string process(const msg::ProcessEvent& event, bus::Clock::time_point now);
  /// The newest status, or null: no answer came. Empty, or a line to tell.
  [[nodiscard]] std::string answer(const msg::CellStatus* status, bus::Clock::time_point now);

 private:
  /// The leader's end, until another one answers.
  struct Death {
    std::int32_t pid = 0;
    bus::Clock::time_point at;
  };

  [[nodiscard]] bool is_of_dead(const msg::CellStatus& status, bus::Clock::time_point now) const;

  std::string leader_;    ///< the node that answered last; empty: none yet
  std::int32_t pid_ = 0;  ///< of its process; 0: not known
  std::string standby_;   ///< the node that is ready to take over, empty: none
  std::optional<Death> died_;
  bool silent_ = false;
};

class SupervisorNews {
 public:
  explicit SupervisorNews(client::Connection& cell) : processes_(cell.participant(), &cell.mailbox()) {}

  /// Lines to tell since the last call. `status`: the newest, or null when no answer came.
  [[nodiscard]] std::vector<std::string> listen(const msg::CellStatus* status);

 private:
  SupervisorStory story_;
  bus::Reader<msg::ProcessEvent> processes_;
};

}  // namespace hecaton::services::cli
