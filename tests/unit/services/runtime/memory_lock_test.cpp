// In a process of its own: what is locked stays so.

#include "services/runtime/memory_lock.hpp"

#include <cstdlib>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <sys/resource.h>

namespace hecaton::services {
namespace {

/// Of /proc/self/status [kB]; −1: not there.
long status_kb(const std::string& key) {
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(key + ":")) return std::strtol(line.c_str() + key.size() + 1, nullptr, 10);
  }
  return -1;
}

bool may_lock() {
  rlimit limit{};
  if (getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  constexpr unsigned long kIpcLock = 1UL << 14U;
  std::ifstream file("/proc/self/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("CapEff:")) return (std::strtoul(line.c_str() + 7, nullptr, 16) & kIpcLock) != 0;
  }
  return false;
}

TEST(MemoryLockDeathTest, LocksWhatItHasAndWillHaveWhereItMay) {
  EXPECT_EXIT(
      {
        const long before = status_kb("RssFile");
        lock_memory();
        const bool read = status_kb("RssFile") > before;
        const long locked = status_kb("VmLck");
        const void* later = std::malloc(64U << 20U);  // mapped anew, and never touched
        const bool follows = later != nullptr && status_kb("VmLck") >= locked + (64 << 10);
        std::exit(!read ? 1 : may_lock() && !(locked > 0 && follows) ? 2 : 0);
      },
      ::testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace hecaton::services
