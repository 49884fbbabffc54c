#pragma once
/// Which host hears which. Standard library only; all times are those of one StallCompensatedClock.
///
/// The agent of each host sends a row: for every other host, the age of the newest packet from it, on the agent's
/// clock. The matrix adds to each age the age of the row itself at this observer.
///
///                 subject   north  west  east
///   row of north              –     8     9      [ms]     north hears west and east
///   row of west               7     –   900               west does not hear east
///   row of east               6    11     –               east hears both: the link from east to west is lost

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/runtime/stall_compensated_clock.hpp"

namespace hecaton::services {

using HostIndex = std::size_t;

struct HostAge {
  std::string host;
  Time age{0};  ///< of the newest packet from it, when the row was sent
};

class ReachabilityMatrix {
 public:
  /// `link_deadline`: a host hears another when it had a packet within this; also how long a row counts. `absence` >
  /// link_deadline: an agent whose rows were missing for this has to find the others first, and they it.
  ReachabilityMatrix(std::vector<std::string> hosts, Time link_deadline, Time absence);

  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] const std::string& name(HostIndex host) const { return rows_[host].host; }
  [[nodiscard]] std::optional<HostIndex> index(std::string_view host) const;  ///< empty: no host of the cell

  /// The row of `observer` arrived at `at`. Unknown hosts in it are ignored.
  void take(HostIndex observer, const std::vector<HostAge>& ages, Time at);

  /// Arrival of the newest row; empty: none came.
  [[nodiscard]] std::optional<Time> arrival(HostIndex observer) const { return rows_[observer].at; }
  /// The newest row is younger than the link deadline.
  [[nodiscard]] bool fresh(HostIndex observer, Time now) const;
  /// When its rows returned after its last absence; 0 before any came.
  [[nodiscard]] Time returned(HostIndex observer) const { return rows_[observer].returned; }
  /// Rows have come without a gap for at least the link deadline.
  [[nodiscard]] bool steady(HostIndex observer, Time now) const;
  /// How long `observer` has not heard `subject`. Empty: no fresh row, or its agent has not heard `subject` since its
  /// last absence.
  [[nodiscard]] std::optional<Time> age(HostIndex observer, HostIndex subject, Time now) const;
  [[nodiscard]] bool hears(HostIndex observer, HostIndex subject, Time now) const;

 private:
  struct Row {
    std::string host;
    std::optional<Time> at{};  // arrival
    Time steady_since{0};
    Time returned{0};
    std::vector<std::optional<Time>> ages{};  // by subject
    std::vector<bool> found{};                // by subject: heard since `returned`
  };
  std::vector<Row> rows_;
  Time link_deadline_, absence_;
};

}  // namespace hecaton::services
