#include "services/ros2/cancellations.hpp"

#include <algorithm>

#include <hecaton/client.hpp>

#include "services/runtime/log.hpp"

namespace hecaton::ros2 {

void Cancellations::add(const std::string& goal, std::function<void()> send, Clock::time_point now) {
  std::erase_if(unsent_, [&](const Entry& entry) { return entry.goal == goal; });
  Entry entry{goal, std::move(send)};
  if (sent(entry)) return;
  tried_ = now;
  unsent_.push_back(std::move(entry));
}

void Cancellations::retry(Clock::time_point now) {
  if (unsent_.empty() || now < tried_ + kPeriod) return;
  tried_ = now;
  std::erase_if(unsent_, [this](const Entry& entry) { return sent(entry); });
}

std::vector<std::string> Cancellations::unsent() const {
  std::vector<std::string> goals;
  for (const Entry& entry : unsent_) goals.push_back(entry.goal);
  return goals;
}

bool Cancellations::sent(const Entry& entry) const {
  try {
    entry.send();
    return true;
  } catch (const Error& error) {
    services::log_warning("trajectory not cancelled at its planner",
                          {{"arm", arm_}, {"goal", entry.goal}, {"reason", error.what()}});
    return false;
  }
}

}  // namespace hecaton::ros2
