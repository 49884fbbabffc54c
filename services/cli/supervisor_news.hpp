#pragma once
/// What becomes of the supervisor itself, which cannot tell its own death: from the agent's events and its answers.

#include <optional>
#include <string>
#include <vector>

#include <idl/health.h>
#include <idl/supervisor.h>

#include "services/cli/client.hpp"

namespace hecaton::services::cli {

/// The same without a network: time is an argument.
class SupervisorStory {
 public:
  /// An event of any process. Empty, or a line to tell.
  [[nodiscard]] std::string process(const msg::ProcessEvent& event, bus::Clock::time_point now);
  /// The newest status, or null: no answer came. Empty, or a line to tell.
  [[nodiscard]] std::string answer(const msg::CellStatus* status, bus::Clock::time_point now);

 private:
  std::optional<bus::Clock::time_point> died_;  ///< and its successor did not answer yet
  bool silent_ = false;
};

class SupervisorNews {
 public:
  explicit SupervisorNews(Client& client) : processes_(client.participant(), &client.mailbox()) {}

  /// Lines to tell since the last call. `status`: the newest, or null when no answer came.
  [[nodiscard]] std::vector<std::string> listen(const msg::CellStatus* status);

 private:
  SupervisorStory story_;
  bus::Reader<msg::ProcessEvent> processes_;
};

}  // namespace hecaton::services::cli
