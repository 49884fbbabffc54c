#include "services/agent/reaper.hpp"

#include <utility>

#include <sys/wait.h>

#include "services/runtime/urgency.hpp"

namespace hecaton::services {

Reaper::~Reaper() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Reaper::take(pid_t child) {
  {
    const std::scoped_lock lock(mutex_);
    children_.push_back(child);
  }
  wake_.notify_one();
}

void Reaper::work() {
  constexpr int kNiceness = 2;
  stand_back(kNiceness);
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || !children_.empty(); });
    if (children_.empty()) return;
    const auto children = std::exchange(children_, {});
    lock.unlock();
    for (const pid_t child : children) waitpid(child, nullptr, 0);
    lock.lock();
  }
}

}  // namespace hecaton::services
