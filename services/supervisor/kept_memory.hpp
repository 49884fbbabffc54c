#pragma once
/// The memory of a supervisor in its file, and whether it found room there.

#include <string>
#include <utility>

#include "services/supervisor/memory.hpp"

namespace hecaton::services {

class KeptMemory {
 public:
  /// Takes up what an earlier life kept. Empty path: nothing is kept. Throws as read_memory() does.
  explicit KeptMemory(std::string path) : path_(std::move(path)) {
    if (auto memory = path_.empty() ? std::nullopt : read_memory(path_)) kept_ = *std::move(memory);
  }

  /// Before it is told: what somebody has heard is never forgotten. What could not be written before is tried again,
  /// also when `memory` is nothing new.
  void keep(Memory memory) {
    const bool known = memory == kept_;
    if (path_.empty() || (known && !forgetful())) return;
    why_ = known ? std::string() : write_memory(path_, memory);
    if (!forgetful()) kept_ = std::move(memory);
  }
  [[nodiscard]] bool keeps() const { return !path_.empty(); }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// As last written.
  [[nodiscard]] const Memory& kept() const { return kept_; }
  /// The newest of what is to be remembered could not be written.
  [[nodiscard]] bool forgetful() const { return !why_.empty(); }
  /// The same as a sentence; empty: all is well.
  [[nodiscard]] std::string failure() const {
    if (!forgetful()) return {};
    return "orders and faults are not remembered, and are lost with this process: " + why_;
  }

 private:
  std::string path_;
  Memory kept_;
  std::string why_;  // it could not be written, last
};

}  // namespace hecaton::services
