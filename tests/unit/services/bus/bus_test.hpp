#pragma once
/// What the tests of the bus share: a domain of their own and patience.

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include "services/bus/endpoint.hpp"

namespace hecaton::bus {

/// Long enough for any machine; tests wait for events and fail only when one never comes.
inline constexpr auto kPatience = std::chrono::seconds(20);

inline constexpr auto kOnceMore = std::chrono::milliseconds(50);

/// A DDS domain that no other test process uses while this object lives. Below those of live cells
/// (tests/support/free_domain.hpp) and the default.
class TestDomain {
 public:
  TestDomain() {
    constexpr int kFirst = 2;
    constexpr int kCount = 40;
    for (int i = 0; i < kCount; ++i) {
      const int candidate = kFirst + (static_cast<int>(::getpid()) + i) % kCount;
      const auto path = std::filesystem::temp_directory_path() / ("hecaton_domain_" + std::to_string(candidate));
      fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
      if (fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) == 0) {
        id_ = candidate;
        return;
      }
      if (fd_ >= 0) ::close(fd_);
    }
    throw std::runtime_error("no free DDS domain for a test");
  }
  ~TestDomain() { ::close(fd_); }
  TestDomain(const TestDomain&) = delete;
  TestDomain& operator=(const TestDomain&) = delete;

  [[nodiscard]] int id() const { return id_; }

 private:
  int fd_ = -1;
  int id_ = 0;
};

/// A cell on one host.
inline ParticipantOptions one_host() {
  ParticipantOptions options;
  options.interfaces = {"127.0.0.1"};
  return options;
}

/// Waits on the reader's mailbox until `done()` holds. It is asked at every event, and again after a while without one:
/// what it writes may be a best-effort sample that gets lost.
template <class T, class Condition>
[[nodiscard]] bool wait_until(Reader<T>& reader, Condition done) {
  const auto until = Clock::now() + kPatience;
  while (!done()) {
    const auto left = until - Clock::now();
    if (left <= Clock::duration::zero()) return false;
    [[maybe_unused]] const bool arrived = reader.wait_for_data(std::min<Clock::duration>(left, kOnceMore));
  }
  return true;
}

/// Two participants of one domain that talk over UDP, as two processes would.
class BusTest : public testing::Test {
 protected:
  TestDomain domain_;
  Participant here_{domain_.id(), "here", one_host()};
  Participant there_{domain_.id(), "there", one_host()};

  template <class T>
  void expect_matched(const Writer<T>& writer, const Reader<T>& reader) {
    ASSERT_TRUE(writer.wait_matched(1, kPatience));
    ASSERT_TRUE(reader.wait_matched(1, kPatience));
  }
};

}  // namespace hecaton::bus
