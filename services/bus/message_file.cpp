#include "services/bus/message_file.hpp"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include "services/bus/type_support.hpp"

namespace hecaton::bus {
namespace {

using CheckpointSupport = GuardedSupport<msg::WorldCheckpointPubSubType, msg::WorldCheckpoint>;

/// Kept: the generated constructor adds up the largest size of every nested element, which takes milliseconds.
CheckpointSupport& support() {
  static CheckpointSupport kept;
  return kept;
}

/// The inverse of file_contents(), zeros behind it allowed.
std::optional<msg::WorldCheckpoint> decoded(const std::string& bytes) {
  msg::WorldCheckpoint message;
  support().read(bytes, message);
  if (message.schema() != msg::SCHEMA_VERSION) return std::nullopt;
  const std::string contents = file_contents(message);
  if (!bytes.starts_with(contents)) return std::nullopt;
  const bool padded = bytes.find_first_not_of('\0', contents.size()) == std::string::npos;
  return padded ? std::optional(std::move(message)) : std::nullopt;
}

}  // namespace

std::string file_contents(const msg::WorldCheckpoint& message) {
  return support().bytes_of(message);
}

ReadMessage read_message(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return {{}, path + " cannot be read"};
  auto message = bytes.empty() ? std::nullopt : decoded(bytes);
  if (!message) return {{}, path + " is damaged"};
  return {std::move(message), {}};
}

}  // namespace hecaton::bus
