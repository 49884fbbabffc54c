#include "services/bus/message_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

namespace hecaton::bus {
namespace {

std::vector<char> encoded(const msg::WorldMemory& message) {
  std::vector<char> bytes(msg::WorldMemory::getCdrSerializedSize(message));
  eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
  eprosima::fastcdr::Cdr cdr(buffer);
  message.serialize(cdr);
  bytes.resize(cdr.getSerializedDataLength());
  return bytes;
}

std::optional<msg::WorldMemory> decoded(std::vector<char> bytes) {
  eprosima::fastcdr::FastBuffer buffer(bytes.data(), bytes.size());
  eprosima::fastcdr::Cdr cdr(buffer);
  msg::WorldMemory message;
  try {
    message.deserialize(cdr);
  } catch (const std::exception&) {  // it ends too soon, or a size in it is absurd
    return std::nullopt;
  }
  if (cdr.getSerializedDataLength() != bytes.size() || message.schema() != msg::SCHEMA_VERSION) return std::nullopt;
  return message;
}

bool write_all(const std::string& path, const std::vector<char>& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  return static_cast<bool>(file.flush());
}

}  // namespace

std::string write_message(const std::string& path, const msg::WorldMemory& message) {
  const std::string next = path + ".next";
  errno = 0;
  if (write_all(next, encoded(message)) && std::rename(next.c_str(), path.c_str()) == 0) return {};
  std::string reason = path + " cannot be written: " + std::strerror(errno);
  std::error_code ignored;
  std::filesystem::remove(next, ignored);
  const std::ofstream emptied(path, std::ios::trunc);  // works on a full disk, too
  return reason;
}

ReadMessage read_message(const std::string& path) {
  if (!std::filesystem::exists(path)) return {};
  std::ifstream file(path, std::ios::binary);
  std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  if (!file) return {{}, path + " cannot be read"};
  if (bytes.empty()) return {{}, path + " is empty: it could not be written the last time"};
  auto message = decoded(std::move(bytes));
  if (!message) return {{}, path + " is damaged"};
  return {std::move(message), {}};
}

}  // namespace hecaton::bus
