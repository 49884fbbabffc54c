#pragma once
/// A cell whose planners and supervisor are silent, for tests of what hecaton-ros2 does then.

#include <atomic>
#include <functional>
#include <memory>
#include <thread>

#include "services/client/connection.hpp"
#include "tests/cell/ros2/ros2_cell.hpp"

namespace hecaton::test {

inline config::CellFile three_puma_with_ros2() {
  config::CellFile file = config::load_cell_file(std::string(HECATON_LIVE_CELLS) + "/three_puma.yaml");
  file.ros2.emplace().ns = "/cell";
  return file;
}

class SilentCell : public testing::Test {
 protected:
  /// Calls `update` in a thread until the end of the test, with a time that is `ahead_` of the clock.
  void serve(const std::function<void(bus::Clock::time_point)>& update) {
    loop_ = std::jthread([this, update](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
        static_cast<void>(mailbox_.wait(5ms));
        update(bus::Clock::now() + ahead_.load());
      }
    });
  }

  FreeDomain cell_domain_;
  FreeDomain ros_domain_;
  config::CellFile file_ = three_puma_with_ros2();
  bus::Mailbox mailbox_;
  bus::Participant participant_{ros_domain_.number(), "/", bus::ros2::participant_options()};
  std::shared_ptr<client::Connection> connection_ =
      client::Connection::make(client::join(file_, cell_domain_.number()));
  RosPeer peer_{ros_domain_.number()};
  std::atomic<std::chrono::seconds> ahead_{0s};
  std::jthread loop_;
};

}  // namespace hecaton::test
