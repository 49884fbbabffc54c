#include "services/cli/process_usage.hpp"

#include <fstream>
#include <sstream>
#include <string>

#include <unistd.h>

namespace hecaton::services::cli {

std::optional<ProcessUsage> process_usage(pid_t pid) {
  const std::string folder = "/proc/" + std::to_string(pid);
  std::ifstream stat(folder + "/stat");
  std::string line;
  if (!std::getline(stat, line)) return std::nullopt;
  const std::size_t name_end = line.rfind(')');  // the name may hold blanks and parentheses
  if (name_end == std::string::npos) return std::nullopt;
  std::istringstream fields(line.substr(name_end + 1));
  // proc(5): after the name come state (3) … utime (14) and stime (15), in clock ticks.
  std::string skipped;
  for (int field = 3; field < 14; ++field) fields >> skipped;
  double user = 0.0;
  double system = 0.0;
  fields >> user >> system;
  ProcessUsage usage;
  usage.cpu_time = (user + system) / static_cast<double>(sysconf(_SC_CLK_TCK));

  std::ifstream status(folder + "/status");
  while (std::getline(status, line)) {
    std::istringstream entry(line);
    std::string key;
    std::uint64_t kilobytes = 0;
    entry >> key >> kilobytes;
    if (key == "VmRSS:") usage.rss_bytes = kilobytes * 1024;
    if (key == "VmHWM:") usage.peak_rss_bytes = kilobytes * 1024;
  }
  return usage;
}

}  // namespace hecaton::services::cli
