#include "services/bus/discovery_server.hpp"

#include <cstdlib>
#include <mutex>

namespace hecaton::bus {

std::vector<std::string> ignore_discovery_servers() {
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  std::vector<std::string> ignored;
  for (const char* name : {"ROS_DISCOVERY_SERVER", "FASTDDS_ENVIRONMENT_FILE"}) {
    const char* value = std::getenv(name);
    if (value == nullptr) continue;
    ignored.push_back(std::string(name) + "=" + value);
    ::unsetenv(name);
  }
  return ignored;
}

}  // namespace hecaton::bus
