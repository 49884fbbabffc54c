#include "services/ros2/unreadable_log.hpp"

#include <chrono>

#include "services/runtime/log.hpp"

namespace hecaton::ros2 {

bool UnreadableLog::note(bus::Clock::time_point now) {
  ++count_;
  ++ignored_;
  if (told_ && now - *told_ < std::chrono::minutes(1)) return false;
  told_ = now;
  services::log_warning("messages ignored: they do not have the layout of their type",
                        {{"topic", name_},
                         {"type", type_},
                         {"count", ignored_},
                         {"what_to_do",
                          "let the sender use this type as its ROS 2 package defines it, and for services "
                          "RMW_IMPLEMENTATION=rmw_fastrtps_cpp"}});
  ignored_ = 0;
  return true;
}

}  // namespace hecaton::ros2
