#pragma once
/// One command's access to a running cell.

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <idl/arm.h>
#include <idl/goal.h>
#include <idl/health.h>
#include <idl/supervisor.h>
#include <idl/world.h>

#include "services/bus/endpoint.hpp"
#include "services/bus/mailbox.hpp"
#include "services/bus/participant.hpp"
#include "services/command_line/failure.hpp"
#include "services/command_line/settings.hpp"
#include "services/config/cell_file.hpp"

namespace hecaton::services::cli {

[[nodiscard]] bus::Clock::duration seconds(double s);

/// A place in a domain, and its name in sentences.
struct Membership {
  bus::Participant participant;
  std::string where;
  std::vector<std::string> supervisors{};  ///< nodes; empty: whatever they are called
};

/// Joins a cell for the time of a command.
[[nodiscard]] bus::Participant visit(const config::CellFile& file, int domain);

/// Joins the domain that the settings name: as one of the cell of --cell, or to listen to any cell. Throws what reading
/// a cell file throws, and std::runtime_error with a sentence.
[[nodiscard]] Membership join(const Settings& settings);

class Client {
 public:
  explicit Client(const Settings& settings);
  /// `timeout`: of each question.
  Client(Membership membership, bus::Clock::duration timeout);
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  /// The supervisor's picture of the cell. Throws Failure: unreachable, or bad input when several cells answer.
  [[nodiscard]] msg::CellStatus status();
  /// The same; false when there is no answer within `timeout`.
  [[nodiscard]] bool poll_status(msg::CellStatus& status, bus::Clock::duration timeout);
  /// An order for the arms, or for the whole cell when there are none. Throws Failure when nobody answers.
  [[nodiscard]] msg::SupervisorReply order(msg::RequestKind kind, const std::vector<std::string>& arms);
  /// Fills in who asks. Throws Failure: unreachable when no world is there, time-out when it does not answer.
  [[nodiscard]] msg::WorldEditReply edit(msg::WorldEditRequest request);

  /// Unique among all clients that run.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& where() const { return where_; }
  /// Whose answer is waited for: "the nodes supervisor and supervisor@beta".
  [[nodiscard]] std::string looked_for() const;
  [[nodiscard]] bus::Participant& participant() { return participant_; }
  /// Told of everything that happens on this client's endpoints and on those that others make for it.
  [[nodiscard]] bus::Mailbox& mailbox() { return mailbox_; }

 private:
  [[nodiscard]] Failure unreachable() const;
  void refuse_several_cells(const std::string& first);

  std::string where_;
  std::vector<std::string> supervisors_;
  bus::Clock::duration timeout_;
  std::string name_;
  std::uint64_t next_request_ = 1;
  bus::Mailbox mailbox_;
  bus::Participant participant_;
  bus::Writer<msg::SupervisorRequest> requests_;
  bus::Reader<msg::SupervisorReply> replies_;
};

/// Throws Failure (bad input) that names the known ones when the cell has no such arm.
const msg::ArmStatus& require_arm(const msg::CellStatus& status, std::string_view arm);
void require_arms(const msg::CellStatus& status, const std::vector<std::string>& arms);
/// The same for obstacles.
void require_obstacle(const msg::CellStatus& status, std::string_view name);
/// Throws Failure (bad input) when another arm carries the object, or none.
void require_carried(const msg::CellStatus& status, std::string_view arm, std::string_view object);

}  // namespace hecaton::services::cli
