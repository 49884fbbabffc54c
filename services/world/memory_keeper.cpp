#include "services/world/memory_keeper.hpp"

#include <utility>

#include "services/bus/message_file.hpp"
#include "services/runtime/kept_file.hpp"
#include "services/runtime/urgency.hpp"

namespace hecaton::services {

MemoryKeeper::MemoryKeeper(std::string path) : path_(std::move(path)) {
  if (!path_.empty()) writer_ = std::thread([this] { write(); });
}

MemoryKeeper::~MemoryKeeper() {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  if (writer_.joinable()) writer_.join();
}

std::uint64_t MemoryKeeper::keep(msg::WorldMemory memory) {
  const std::scoped_lock lock(mutex_);
  ++given_;
  if (path_.empty()) {
    tried_ = kept_ = given_;
  } else {
    next_ = std::move(memory);
    wake_.notify_one();
  }
  return given_;
}

std::optional<std::string> MemoryKeeper::outcome(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  if (number <= kept_) return std::string();
  if (number <= tried_) return failure_;
  std::string silent = silence();
  return silent.empty() ? std::nullopt : std::optional(std::move(silent));
}

std::string MemoryKeeper::failure() const {
  const std::scoped_lock lock(mutex_);
  std::string silent = silence();
  return silent.empty() ? failure_ : silent;
}

void MemoryKeeper::look(Clock::time_point now) {
  const std::scoped_lock lock(mutex_);
  watch_.look(now, tried_ < given_, tried_);
}

std::string MemoryKeeper::silence() const {
  return complaint_about("the thread that writes " + path_, watch_.silence(), kLongestWrite);
}

void MemoryKeeper::write() {
  stay_behind_loops();
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || next_; });
    if (!next_) return;
    const msg::WorldMemory memory = *std::exchange(next_, std::nullopt);
    const std::uint64_t number = given_;
    lock.unlock();
    std::string failure = keep_in_file(path_, bus::file_contents(memory), '\0');
    lock.lock();
    tried_ = number;
    if (failure.empty()) kept_ = number;
    failure_ = std::move(failure);
  }
}

}  // namespace hecaton::services
