#include "tests/support/free_domain.hpp"

#include <filesystem>
#include <random>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

namespace hecaton::test {

FreeDomain::FreeDomain() {
  // Above the domains of the default and the examples, and below 101: the kernel assigns ports of higher domains
  // freely.
  constexpr int kFirst = 44;
  constexpr int kCount = 57;
  const int start = static_cast<int>(std::random_device{}() % kCount);
  for (int i = 0; i < kCount; ++i) {
    const int number = kFirst + (start + i) % kCount;
    const auto path = std::filesystem::temp_directory_path() / ("hecaton-domain-" + std::to_string(number) + ".lock");
    const int lock = open(path.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666);
    if (lock >= 0 && flock(lock, LOCK_EX | LOCK_NB) == 0) {
      number_ = number;
      lock_ = lock;
      return;
    }
    if (lock >= 0) close(lock);
  }
  throw std::runtime_error("no DDS domain from 44 to 100 is free");
}

FreeDomain::~FreeDomain() {
  close(lock_);
}

}  // namespace hecaton::test
