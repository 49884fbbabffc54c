#pragma once
/// Serves the page of a recording.

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "services/replay/recorded_files.hpp"
#include "services/replay/replay.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/shutdown.hpp"
#include "services/view/page_server.hpp"
#include "services/view/web_protection.hpp"

namespace hecaton::services::replay {

/// Commands of all pages, from the thread of the server to the loop. Of several seeks in a row only the last counts.
/// Thread-safe.
class CommandQueue {
 public:
  static constexpr std::size_t kMost = 256;  ///< further ones are dropped

  void push(std::string_view command);
  [[nodiscard]] std::vector<std::string> take();

 private:
  std::mutex mutex_;
  std::vector<std::string> commands_;
};

/// For one thread.
class ReplayService {
 public:
  /// Listens from now on; `address` without a port: at a free one. The references must outlive it. Throws
  /// std::runtime_error with a sentence when the address cannot be used.
  ReplayService(const RecordedFiles& files, Replay& replay, const config::View& address,
                const ShutdownSignal& shutdown);

  /// Returns when `shutdown` was requested. Throws recorder::RecordingError when a file has changed.
  void run();

  /// Of the page, with its token if it needs one.
  [[nodiscard]] std::string url() const;
  /// As certificate_note().
  [[nodiscard]] std::optional<std::string> note() const { return certificate_note(protection_); }

 private:
  Replay& replay_;
  config::View address_;
  std::optional<WebProtection> protection_;
  CommandQueue commands_;
  PeriodicLoop loop_;
  PageServer page_;
};

}  // namespace hecaton::services::replay
