#include "services/bus/message_file.hpp"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <utility>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

namespace hecaton::bus {
namespace {

std::optional<msg::WorldMemory> decoded(std::string bytes) {
  eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
  eprosima::fastcdr::Cdr cdr(buffer);
  msg::WorldMemory message;
  try {
    message.deserialize(cdr);
  } catch (const std::exception&) {  // it ends too soon, or a size in it is absurd
    return std::nullopt;
  }
  const auto end = bytes.begin() + static_cast<std::ptrdiff_t>(cdr.getSerializedDataLength());
  const bool padded = std::all_of(end, bytes.end(), [](char byte) { return byte == '\0'; });
  if (!padded || message.schema() != msg::SCHEMA_VERSION) return std::nullopt;
  return message;
}

}  // namespace

std::string file_contents(const msg::WorldMemory& message) {
  std::string bytes(msg::WorldMemory::getCdrSerializedSize(message), '\0');
  eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
  eprosima::fastcdr::Cdr cdr(buffer);
  message.serialize(cdr);
  bytes.resize(cdr.getSerializedDataLength());
  return bytes;
}

ReadMessage read_message(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return {{}, path + " cannot be read"};
  auto message = bytes.empty() ? std::nullopt : decoded(std::move(bytes));
  if (!message) return {{}, path + " is damaged"};
  return {std::move(message), {}};
}

}  // namespace hecaton::bus
