#include "services/ros2/status_poller.hpp"

#include <utility>

namespace hecaton::ros2 {

StatusPoller::StatusPoller(Cell cell)
    : cell_(std::move(cell)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

StatusPoller::Answer StatusPoller::newest() const {
  const std::scoped_lock lock(mutex_);
  return answer_;
}

void StatusPoller::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::shared_ptr<const CellStatus> status;
    std::string problem;
    try {
      status = std::make_shared<const CellStatus>(cell_.status({kPeriod, stop}));
    } catch (const Error& error) {
      problem = error.what();
    }
    std::unique_lock lock(mutex_);
    answer_ = {std::move(status), std::move(problem), answer_.number + 1};
    wait_.wait_for(lock, stop, kPeriod, [] { return false; });
  }
}

}  // namespace hecaton::ros2
