#pragma once
/// Times of ROS 2 messages.

#include <chrono>
#include <cmath>

#include "services/bus/endpoint.hpp"
#include "services/ros2_messages/ros2_types.hpp"

namespace hecaton::ros2 {

/// Time of the wall clock, which ROS 2 nodes use.
[[nodiscard]] inline Time ros_time(std::chrono::system_clock::time_point at) {
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(at.time_since_epoch()).count();
  return {static_cast<std::int32_t>(ns / 1'000'000'000), static_cast<std::uint32_t>(ns % 1'000'000'000)};
}
/// The time of an instant of the steady clock.
[[nodiscard]] inline Time ros_time(bus::Clock::time_point at) {
  return ros_time(std::chrono::system_clock::now() +
                  std::chrono::duration_cast<std::chrono::system_clock::duration>(at - bus::Clock::now()));
}
[[nodiscard]] inline Duration ros_duration(double seconds) {
  const double whole = std::floor(seconds);
  return {static_cast<std::int32_t>(whole), static_cast<std::uint32_t>((seconds - whole) * 1e9)};
}
[[nodiscard]] inline double seconds_of(const Duration& duration) {
  return static_cast<double>(duration.sec) + 1e-9 * static_cast<double>(duration.nanosec);
}

/// A stamp that its sender has not set.
[[nodiscard]] inline bool is_stamp_zero(const Time& stamp) {
  return stamp.sec == 0 && stamp.nanosec == 0;
}

}  // namespace hecaton::ros2
