#include "services/ros2/unreadable_log.hpp"

#include <chrono>

#include "services/runtime/log.hpp"

namespace hecaton::ros2 {

bool UnreadableLog::note(bus::Clock::time_point now) {
  ++ignored_;
  if (told_ && now - *told_ < std::chrono::minutes(1)) return false;
  told_ = now;
  services::log_warning("messages ignored: they do not have the layout of their type",
                        {{"topic", name_},
                         {"type", type_},
                         {"count", ignored_},
                         {"what_to_do",
                          "let the sender use the fields of this type as docs/reference/ros2.md names them, and for "
                          "services RMW_IMPLEMENTATION=rmw_fastrtps_cpp"}});
  ignored_ = 0;
  return true;
}

}  // namespace hecaton::ros2
