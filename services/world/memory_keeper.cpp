#include "services/world/memory_keeper.hpp"

#include <utility>

#include "services/bus/message_file.hpp"

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
    kept_ = given_;
  } else {
    next_ = std::move(memory);
    wake_.notify_one();
  }
  return given_;
}

bool MemoryKeeper::kept(std::uint64_t number) const {
  const std::scoped_lock lock(mutex_);
  return kept_ >= number;
}

std::string MemoryKeeper::failure() const {
  const std::scoped_lock lock(mutex_);
  return failure_;
}

void MemoryKeeper::write() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || next_; });
    if (!next_) return;
    const msg::WorldMemory memory = *std::exchange(next_, std::nullopt);
    const std::uint64_t number = given_;
    lock.unlock();
    std::string failure = bus::write_message(path_, memory);
    lock.lock();
    kept_ = number;
    failure_ = std::move(failure);
  }
}

}  // namespace hecaton::services
