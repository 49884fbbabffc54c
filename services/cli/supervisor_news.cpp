#include "services/cli/supervisor_news.hpp"

#include <chrono>
#include <utility>

#include "services/runtime/node_name.hpp"

namespace hecaton::services::cli {

std::string SupervisorStory::process(const msg::ProcessEvent& event, bus::Clock::time_point now) {
  if (event.node() != supervisor_node() || event.kind() != msg::PROCESS_EXITED || event.wanted()) return {};
  died_ = now;
  return "the supervisor died (process " + std::to_string(event.pid()) +
         (event.signal_number() != 0 ? ", signal " + std::to_string(event.signal_number())
                                     : ", exit code " + std::to_string(event.exit_code())) +
         "): arms go on, faults and orders wait for its successor";
}

std::string SupervisorStory::answer(const msg::CellStatus* status, bus::Clock::time_point now) {
  if (status == nullptr) {
    if (died_ || std::exchange(silent_, true)) return {};
    return "the supervisor does not answer: arms go on, faults and orders wait for it";
  }
  const bool was_silent = std::exchange(silent_, false);
  if (!died_) return was_silent ? "the supervisor answers again" : "";
  // The answer may still be the dead one's, which was up longer than it is dead.
  if (status->uptime() > std::chrono::duration<double>(now - *died_).count()) return {};
  died_.reset();
  return "the supervisor is back: a successor took its place";
}

std::vector<std::string> SupervisorNews::listen(const msg::CellStatus* status) {
  std::vector<std::string> lines;
  const auto tell = [&](std::string line) {
    if (!line.empty()) lines.push_back(std::move(line));
  };
  for (const auto& sample : processes_.take()) {
    if (!sample.disposed) tell(story_.process(sample.value, sample.received));
  }
  tell(story_.answer(status, bus::Clock::now()));
  return lines;
}

}  // namespace hecaton::services::cli
