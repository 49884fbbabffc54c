#include "services/arm_driver/devices/universal_robots/dashboard.hpp"

#include <utility>

namespace hecaton::device::universal_robots {
namespace {

constexpr int kDashboardPort = 29999;
constexpr std::chrono::seconds kAnswerLimit{8};
/// Between the beginnings of two connections.
constexpr std::chrono::seconds kReopen{1};
constexpr std::size_t kLongestLine = 4096;

}  // namespace

void Dashboard::open(const std::string& address, Clock::time_point now) {
  address_ = address;
  has_greeted_ = false;
  connect(now);
}

void Dashboard::connect(Clock::time_point now) {
  drop();
  connection_.connect(address_, kDashboardPort);
  deadline_ = now + kAnswerLimit;
  reopen_at_ = now + kReopen;
}

void Dashboard::close() {
  drop();
  address_.clear();
}

void Dashboard::drop() {
  connection_.close();
  greeted_ = asked_ = false;
  commands_.clear();
  answers_.clear();
}

void Dashboard::update(Clock::time_point now) {
  if (connection_.state() == TcpConnection::State::kClosed) {
    if (!address_.empty() && now >= reopen_at_) connect(now);
    return;
  }
  connection_.update();
  std::string& bytes = connection_.received();
  for (auto end = bytes.find('\n'); end != std::string::npos; end = bytes.find('\n')) {
    std::string line = bytes.substr(0, end);
    bytes.erase(0, end + 1);
    if (!line.empty() && line.back() == '\r') line.pop_back();
    has_greeted_ = true;
    if (!std::exchange(greeted_, true) || !asked_) continue;  // the greeting, or words that nothing asked for
    answers_.push_back({std::move(commands_.front()), std::move(line)});
    commands_.pop_front();
    asked_ = false;
    send_next(now);
  }
  const bool waits = !greeted_ || asked_;
  const bool closed = connection_.state() == TcpConnection::State::kClosed;
  if (closed || bytes.size() > kLongestLine || (waits && now > deadline_)) drop();
}

void Dashboard::send(const std::string& command, Clock::time_point now) {
  commands_.push_back(command);
  send_next(now);
}

void Dashboard::send_next(Clock::time_point now) {
  if (asked_ || commands_.empty() || !is_open()) return;
  connection_.send(commands_.front() + "\n");
  asked_ = true;
  deadline_ = now + kAnswerLimit;
}

std::optional<Dashboard::Answer> Dashboard::take() {
  if (answers_.empty()) return std::nullopt;
  Answer answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

}  // namespace hecaton::device::universal_robots
