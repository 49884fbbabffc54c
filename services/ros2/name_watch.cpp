#include "services/ros2/name_watch.hpp"

#include "services/ros2/publisher.hpp"

namespace hecaton::ros2 {

NameWatch::NameWatch(bus::Participant& participant, const std::string& ns, bus::Mailbox& mailbox)
    : reader_(participant, topic_of(ns + "/robot_description", type::kString, Delivery::kStream), mailbox) {}

bool NameWatch::update(Clock::time_point now) {
  static_cast<void>(reader_.take());
  if (reader_.matched() <= 1) {
    since_.reset();
    return false;
  }
  if (!since_) since_ = now;
  if (told_ || now < *since_ + kPatience) return false;
  told_ = true;
  return true;
}

}  // namespace hecaton::ros2
