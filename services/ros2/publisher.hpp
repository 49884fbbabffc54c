#pragma once
/// Typed endpoints of ROS 2: serialised messages of services/bus with the types of ros2_types.hpp.

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/bus/ros2_endpoint.hpp"
#include "services/ros2/cdr.hpp"
#include "services/ros2/ros2_types.hpp"

namespace hecaton::ros2 {

/// Policies that nodes of ROS 2 expect on a topic.
enum class Delivery {
  kStream,      ///< reliable, the last 10 samples
  kTransforms,  ///< reliable, the last 100 samples
  kLatched,     ///< reliable; late joiners get the last sample
  kClock,       ///< best effort, the last sample
};

[[nodiscard]] inline bus::ros2::Topic topic_of(const std::string& name, const TypeInfo& type, Delivery delivery) {
  bus::ros2::Topic topic;
  topic.name = name;
  topic.type = type.name;
  topic.hash = type.hash;
  topic.reliable = delivery != Delivery::kClock;
  topic.transient_local = delivery == Delivery::kLatched;
  topic.depth = delivery == Delivery::kStream ? 10 : delivery == Delivery::kTransforms ? 100 : 1;
  return topic;
}

[[nodiscard]] inline bus::ros2::Service service_of(const std::string& name, const TypeInfo& type) {
  bus::ros2::Service service;
  service.name = name;
  service.type = type.name;
  service.hash = type.hash;
  return service;
}

/// For one thread.
template <class Message>
class Publisher {
 public:
  Publisher(bus::Participant& participant, const std::string& name, const TypeInfo& type,
            Delivery delivery = Delivery::kStream)
      : writer_(participant, topic_of(name, type, delivery)) {}

  void publish(const Message& message) {
    encode(message, bytes_);
    writer_.write(bytes_);
  }
  /// A node reads the topic.
  [[nodiscard]] bool wanted() const { return writer_.matched() > 0; }
  [[nodiscard]] bus::EndpointId id() const { return writer_.id(); }

 private:
  bus::ros2::Writer writer_;
  Bytes bytes_;
};

/// For one thread.
template <class Message>
class Subscription {
 public:
  Subscription(bus::Participant& participant, const std::string& name, const TypeInfo& type, bus::Mailbox& mailbox)
      : reader_(participant, topic_of(name, type, Delivery::kStream), mailbox) {}

  /// The well-formed messages since the last call, oldest first.
  [[nodiscard]] std::vector<Message> take() {
    std::vector<Message> messages;
    for (const bus::ros2::Sample& sample : reader_.take()) {
      if (auto message = decoded<Message>(sample.bytes)) messages.push_back(std::move(*message));
    }
    return messages;
  }
  [[nodiscard]] bus::EndpointId id() const { return reader_.id(); }

 private:
  bus::ros2::Reader reader_;
};

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

}  // namespace hecaton::ros2
