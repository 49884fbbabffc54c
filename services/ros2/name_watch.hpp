#pragma once
/// Finds out whether another node publishes under the names of this service.

#include <optional>
#include <string>

#include "services/bus/ros2_endpoint.hpp"

namespace hecaton::ros2 {

/// Looks for other writers of NAMESPACE/robot_description: a second cell with equal names, or a robot_state_publisher.
/// For one thread.
class NameWatch {
 public:
  using Clock = bus::Clock;

  /// Another writer counts when it has been there for this long. A process of this service that was killed stays known
  /// for 20 s.
  static constexpr std::chrono::seconds kPatience{30};

  /// `participant` also has the service's own writer. `mailbox` must outlive it.
  NameWatch(bus::Participant& participant, const std::string& ns, bus::Mailbox& mailbox);

  /// True once: another node has had the name for a long time.
  [[nodiscard]] bool update(Clock::time_point now);
  [[nodiscard]] bus::EndpointId id() const { return reader_.id(); }

 private:
  bus::ros2::Reader reader_;
  std::optional<Clock::time_point> since_;  ///< of the other writer
  bool told_ = false;
};

}  // namespace hecaton::ros2
