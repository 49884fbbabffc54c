#pragma once
/// What happened in a recording, for its time line.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <idl/goal.h>
#include <idl/health.h>

#include "services/bus/endpoint.hpp"

namespace hecaton::services::replay {

enum class MarkKind : std::uint8_t { kFault, kGoal, kMode };

struct Mark {
  MarkKind kind{};
  bus::Clock::time_point at;                    ///< when its message was received
  std::optional<bus::Clock::time_point> until;  ///< of a fault: when it was cleared; empty: open at the end
  std::string subject;                          ///< the arm, or the subject of the fault; empty: the cell
  std::string text;
  std::string severity;  ///< of a fault: "error"; empty: no fault
};

/// Collects marks from the messages of a recording, in their order. What had ended before the recording began is no
/// mark. For one thread.
class MarkFinder {
 public:
  static constexpr std::size_t kMost = 5000;  ///< of each kind; further ones are left out

  void take(const bus::Sample<msg::Fault>& sample);
  void take(const bus::Sample<msg::GoalStatus>& sample);
  /// A mode that is in force: CellModeView has accepted it.
  void take_mode(const msg::CellMode& mode, bus::Clock::time_point at);

  /// By time.
  [[nodiscard]] std::vector<Mark> take_marks();
  [[nodiscard]] std::uint64_t left_out() const { return left_out_; }

 private:
  void add(Mark mark);

  std::vector<Mark> marks_;
  std::map<MarkKind, std::size_t> counts_;
  std::uint64_t left_out_ = 0;
  std::map<std::string, std::optional<std::size_t>> faults_;             ///< by id: index of the mark; empty: none
  std::map<std::pair<std::string, std::string>, msg::GoalState> goals_;  ///< by arm and id
  std::optional<msg::Mode> mode_;
  std::map<std::string, msg::Mode> arms_;  ///< with an order of their own
};

}  // namespace hecaton::services::replay
