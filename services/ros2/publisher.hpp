#pragma once
/// Typed endpoints of ROS 2: serialised messages of services/bus with the types of ros2_types.hpp.

#include <cstdint>
#include <functional>
#include <string>

#include "services/bus/ros2_endpoint.hpp"
#include "services/ros2/unreadable_log.hpp"
#include "services/ros2_messages/cdr.hpp"
#include "services/ros2_messages/ros2_types.hpp"
#include "services/ros2_messages/time.hpp"

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
  // More than any such request has, so that the log can tell of one with another layout.
  constexpr std::uint32_t kShort = 4096;
  if (type.short_request) service.largest_request = kShort;
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
  [[nodiscard]] bool wanted() const { return readers() > 0; }
  [[nodiscard]] int readers() const { return writer_.matched(); }
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
      : reader_(participant, topic_of(name, type, Delivery::kStream), mailbox), unreadable_(name, type.name) {}

  /// Calls `use` with each well-formed message since the last call, oldest first. The log tells of others. A message
  /// takes several times the memory of its bytes: no two are decoded at the same time.
  void take_each(const std::function<void(const Message&)>& use) {
    for (const bus::ros2::Sample& sample : reader_.take()) {
      if (const auto message = decoded<Message>(sample.bytes)) {
        use(*message);
      } else {
        unreadable_.note(sample.received);
      }
    }
  }
  /// Messages that were not well-formed, since the start.
  [[nodiscard]] std::uint64_t unreadable() const { return unreadable_.count(); }
  [[nodiscard]] bus::EndpointId id() const { return reader_.id(); }

 private:
  bus::ros2::Reader reader_;
  UnreadableLog unreadable_;
};

}  // namespace hecaton::ros2
