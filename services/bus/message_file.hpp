#pragma once
/// A message as a file's contents, replaced as a whole: a crash leaves either the old or the new one.

#include <optional>
#include <string>

#include <idl/world.h>

namespace hecaton::bus {

/// Empty, or the sentence that says why it could not be written; then the old contents are gone, too, and the file is
/// empty: what is out of date must not be taken for the newest.
[[nodiscard]] std::string write_message(const std::string& path, const msg::WorldMemory& message);

struct ReadMessage {
  std::optional<msg::WorldMemory> message;
  std::string error;  ///< a sentence; empty when there is no such file
};
[[nodiscard]] ReadMessage read_message(const std::string& path);

}  // namespace hecaton::bus
