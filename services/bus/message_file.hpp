#pragma once
/// The world's checkpoint as the contents of a file.

#include <optional>
#include <string>

#include <idl/world.h>

namespace hecaton::bus {

/// The serialised checkpoint. In the file, zeros may follow it.
[[nodiscard]] std::string file_contents(const msg::WorldCheckpoint& message);

struct ReadMessage {
  std::optional<msg::WorldCheckpoint> message;
  std::optional<std::string> error;  ///< a sentence when the file exists and is unreadable or damaged
};
/// Reads the file at `path`. Without such a file both members are empty.
[[nodiscard]] ReadMessage read_message(const std::string& path);

}  // namespace hecaton::bus
