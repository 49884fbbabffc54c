#pragma once
/// What the action of an arm leaves to the process that is started after this one, in a file of the run.

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/bus/mailbox.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::ros2 {

struct SavedGoal {
  GoalInfo info;
  std::int8_t status = 0;
  bool ended = false;         ///< false: the next two mean nothing
  TrajectoryResult result;    ///< of its end
  std::int64_t ended_ns = 0;  ///< steady clock
  static void fields(auto& self, auto& visit) { visit(self.info, self.status, self.ended, self.result, self.ended_ns); }
};

/// A request for the result of a goal that has not ended.
struct SavedRequest {
  UUID goal;
  std::array<std::uint8_t, 16> client{};  ///< endpoint that receives the reply
  std::int64_t number = 0;                ///< of the request
  static void fields(auto& self, auto& visit) { visit(self.goal, self.client, self.number); }
};

/// A goal under way.
struct SavedTrajectory {
  UUID id;
  std::string goal;  ///< identifier for the planner, which may not have received it
  TrajectoryGoal order;
  std::vector<double> start;  ///< position of the arm when it was accepted [rad | m]
  std::int64_t begun_ns = 0;  ///< steady clock
  bool canceling = false;
  std::vector<std::string> replaced;  ///< goals with which the planner goes on if it rejects this one
  static void fields(auto& self, auto& visit) {
    visit(self.id, self.goal, self.order, self.start, self.begun_ns, self.canceling, self.replaced);
  }
};

struct SavedAction {
  std::string arm;
  std::vector<SavedGoal> goals;  ///< in the order of acceptance
  std::vector<SavedRequest> requests;
  std::vector<SavedTrajectory> active;   ///< at most one
  std::vector<std::string> uncancelled;  ///< goals of the planner that have ended here, and are still to be cancelled
  static void fields(auto& self, auto& visit) {
    visit(self.arm, self.goals, self.requests, self.active, self.uncancelled);
  }
};

// Instants of the steady clock as they are saved: nanoseconds.
[[nodiscard]] inline std::int64_t stamp_of(bus::Clock::time_point time) {
  return std::chrono::nanoseconds(time.time_since_epoch()).count();
}
[[nodiscard]] inline bus::Clock::time_point time_of(std::int64_t stamp_ns) {
  return bus::Clock::time_point(std::chrono::nanoseconds(stamp_ns));
}

/// For one thread.
class ActionCheckpoint {
 public:
  /// `path` empty: keeps nothing.
  explicit ActionCheckpoint(std::string path) : path_(std::move(path)) {}

  /// What an earlier process saved for `arm`; empty: nothing. Logs a file that is damaged or of another arm.
  [[nodiscard]] std::optional<SavedAction> load(const std::string& arm) const;
  /// Logs the first of several failures.
  void save(const SavedAction& action);

 private:
  std::string path_;
  bool failed_ = false;
};

}  // namespace hecaton::ros2
