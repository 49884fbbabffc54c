#include "services/agent/reaper.hpp"

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "services/runtime/urgency.hpp"

namespace hecaton::services {

Reaper::Reaper() {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  begin_ = ends[0];
  end_ = ends[1];
  thread_ = std::thread([this] { work(); });
}

Reaper::~Reaper() {
  close(end_);
  thread_.join();
  close(begin_);
}

void Reaper::take(pid_t child) const {
  static_cast<void>(TEMP_FAILURE_RETRY(write(end_, &child, sizeof child)));  // the pipe has room for thousands
}

void Reaper::work() const {
  constexpr int kNiceness = 2;
  stand_back(kNiceness);
  pid_t child = 0;
  // The process's signals may come to any thread.
  while (TEMP_FAILURE_RETRY(read(begin_, &child, sizeof child)) == sizeof child) {
    static_cast<void>(TEMP_FAILURE_RETRY(waitpid(child, nullptr, 0)));
  }
}

}  // namespace hecaton::services
