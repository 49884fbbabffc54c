#pragma once
/// Sends goals and hears what becomes of them.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "services/cli/client.hpp"

namespace hecaton::services::cli {

/// `a` says something later of its arm than `b`.
[[nodiscard]] bool is_later(const msg::GoalStatus& a, const msg::GoalStatus& b);

class Goals {
 public:
  /// Whatever happens is announced in the client's mailbox.
  explicit Goals(Client& client);

  /// A goal for the arm with a name of its own; what to do is left to the caller.
  [[nodiscard]] msg::Goal draft(const std::string& arm);
  /// Throws Failure (unreachable) when it cannot be written.
  void send(const msg::Goal& goal);
  void cancel(const msg::Goal& goal);

  /// Statuses of any goal that have arrived since the last call, oldest first.
  [[nodiscard]] std::vector<msg::GoalStatus> news();

 private:
  Client& client_;
  std::uint64_t sequence_ = 0;
  bus::Writer<msg::Goal> goals_;
  bus::Reader<msg::GoalStatus> statuses_;
};

/// What `status` means for who waits for the goal to be reached.
[[nodiscard]] ExitCode outcome_code(const msg::GoalStatus& status);

}  // namespace hecaton::services::cli
