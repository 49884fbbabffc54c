#pragma once
/// Requests the status of the cell from its supervisor, in a thread of its own.

#include <condition_variable>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>

#include <hecaton/client.hpp>

namespace hecaton::ros2 {

/// Thread-safe.
class StatusPoller {
 public:
  static constexpr std::chrono::seconds kPeriod{1};

  /// Begins to request. The destructor ends it at once.
  explicit StatusPoller(Cell cell);

  /// The newest answer. `status` is null and `problem` a sentence while no supervisor answers.
  struct Answer {
    std::shared_ptr<const CellStatus> status;
    std::string problem;
    std::uint64_t number = 0;  ///< of the request; grows
  };
  [[nodiscard]] Answer newest() const;

 private:
  void run(const std::stop_token& stop);

  Cell cell_;
  mutable std::mutex mutex_;
  std::condition_variable_any wait_;
  Answer answer_;
  std::jthread thread_;
};

}  // namespace hecaton::ros2
