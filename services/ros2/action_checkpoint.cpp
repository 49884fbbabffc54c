#include "services/ros2/action_checkpoint.hpp"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include "services/ros2_messages/cdr.hpp"
#include "services/runtime/atomic_file.hpp"
#include "services/runtime/log.hpp"

namespace hecaton::ros2 {

// The file begins with the size of what follows; zeros are behind it.
std::optional<SavedAction> ActionCheckpoint::load(const std::string& arm) const {
  if (path_.empty() || !std::filesystem::exists(path_)) return std::nullopt;
  std::ifstream file(path_, std::ios::binary);
  const Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::uint64_t size = 0;
  if (bytes.size() >= sizeof size) std::memcpy(&size, bytes.data(), sizeof size);
  std::optional<SavedAction> action;
  if (bytes.size() >= sizeof size && size <= bytes.size() - sizeof size) {
    action = decoded<SavedAction>(std::span(bytes).subspan(sizeof size, size));
  }
  if (action && action->arm == arm) return action;
  services::log_warning("trajectories before the restart are forgotten: the file is damaged",
                        {{"arm", arm}, {"file", path_}});
  return std::nullopt;
}

void ActionCheckpoint::save(const SavedAction& action) {
  if (path_.empty()) return;
  const Bytes bytes = encoded(action);
  const std::uint64_t size = bytes.size();
  std::string contents(reinterpret_cast<const char*>(&size), sizeof size);
  contents.append(bytes.begin(), bytes.end());
  const auto failure = services::write_atomically(path_, std::move(contents), '\0');
  if (failure && !failed_) {
    services::log_warning("trajectories would not survive a restart", {{"arm", action.arm}, {"reason", *failure}});
  }
  failed_ = failure.has_value();
}

}  // namespace hecaton::ros2
