#pragma once
/// A message as a file's contents.

#include <optional>
#include <string>

#include <idl/world.h>

namespace hecaton::bus {

/// Zeros may follow them in the file.
[[nodiscard]] std::string file_contents(const msg::WorldMemory& message);

struct ReadMessage {
  std::optional<msg::WorldMemory> message;
  std::string error;  ///< a sentence; empty when there is no such file
};
[[nodiscard]] ReadMessage read_message(const std::string& path);

}  // namespace hecaton::bus
