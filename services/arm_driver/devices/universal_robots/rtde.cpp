#include "services/arm_driver/devices/universal_robots/rtde.hpp"

#include <algorithm>
#include <bit>

#include "planner/model/source_file.hpp"

namespace hecaton::device::universal_robots {
namespace {

constexpr std::size_t kHeader = 3;  // bytes

void put(std::string& bytes, std::uint64_t value, int size) {
  for (int shift = 8 * (size - 1); shift >= 0; shift -= 8) bytes.push_back(static_cast<char>((value >> shift) & 0xFFU));
}

}  // namespace

void put_u8(std::string& bytes, std::uint8_t value) {
  bytes.push_back(static_cast<char>(value));
}
void put_u16(std::string& bytes, std::uint16_t value) {
  put(bytes, value, 2);
}
void put_u32(std::string& bytes, std::uint32_t value) {
  put(bytes, value, 4);
}
void put_f64(std::string& bytes, double value) {
  put(bytes, std::bit_cast<std::uint64_t>(value), 8);
}

std::string package(PackageType type, std::string_view payload) {
  std::string bytes;
  put_u16(bytes, static_cast<std::uint16_t>(kHeader + payload.size()));
  put_u8(bytes, static_cast<std::uint8_t>(type));
  return bytes.append(payload);
}

template <class Unsigned>
std::optional<Unsigned> ByteReader::number() {
  if (left_.size() < sizeof(Unsigned)) {
    left_ = {};
    return std::nullopt;
  }
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) value = value << 8U | static_cast<std::uint8_t>(left_[i]);
  left_.remove_prefix(sizeof(Unsigned));
  return static_cast<Unsigned>(value);
}

std::optional<std::uint8_t> ByteReader::u8() {
  return number<std::uint8_t>();
}
std::optional<std::uint16_t> ByteReader::u16() {
  return number<std::uint16_t>();
}
std::optional<std::uint32_t> ByteReader::u32() {
  return number<std::uint32_t>();
}
std::optional<std::uint64_t> ByteReader::u64() {
  return number<std::uint64_t>();
}
std::optional<std::int32_t> ByteReader::i32() {
  const auto value = u32();
  return value ? std::optional(std::bit_cast<std::int32_t>(*value)) : std::nullopt;
}
std::optional<double> ByteReader::f64() {
  const auto value = u64();
  return value ? std::optional(std::bit_cast<double>(*value)) : std::nullopt;
}

std::optional<std::string_view> ByteReader::text(std::size_t size) {
  if (left_.size() < size) {
    left_ = {};
    return std::nullopt;
  }
  const std::string_view text = left_.substr(0, size);
  left_.remove_prefix(size);
  return text;
}

Framing next_package(std::string_view bytes) {
  ByteReader reader(bytes);
  const auto size = reader.u16();
  const auto type = reader.u8();
  if (size && *size < kHeader) return {.package = {}, .size = 0, .broken = true};
  if (!type || bytes.size() < *size) return {};
  return {.package = Package{static_cast<PackageType>(*type), bytes.substr(kHeader, *size - kHeader)},
          .size = *size,
          .broken = false};
}

std::optional<TextMessage> text_message(std::string_view payload, int version) {
  ByteReader reader(payload);
  TextMessage text;
  if (version < 2) {
    const auto level = reader.u8();
    if (!level) return std::nullopt;
    text.level = *level;
    text.message = reader.rest();
    return text;
  }
  const auto field = [&]() -> std::optional<std::string> {
    const auto size = reader.u8();
    const auto words = size ? reader.text(*size) : std::nullopt;
    return words ? std::optional(std::string(*words)) : std::nullopt;
  };
  auto message = field();
  auto source = field();
  const auto level = reader.u8();
  if (!message || !source || !level) return std::nullopt;
  return TextMessage{std::move(*message), std::move(*source), *level};
}

std::string readable(std::string_view text) {
  constexpr std::size_t kMost = 200;
  std::string result;
  while (!text.empty()) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
    const std::size_t length = planner::utf8_length(text, 0);
    // Controls; line and paragraph separators; marks that turn the direction of writing.
    const bool control = length < 2 ? byte(0) < 0x20 || byte(0) == 0x7F : byte(0) == 0xC2 && byte(1) < 0xA0;
    const bool separator = length == 3 && byte(0) == 0xE2 && byte(1) == 0x80 && byte(2) >= 0xA8 && byte(2) <= 0xAE;
    const bool isolate = length == 3 && byte(0) == 0xE2 && byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9;
    const std::size_t taken = std::max<std::size_t>(length, 1);
    if (result.size() + taken > kMost) break;
    result += length == 0 || control || separator || isolate ? "?" : text.substr(0, taken);
    text.remove_prefix(taken);
  }
  return result;
}

std::vector<std::string> split(std::string_view words) {
  std::vector<std::string> list;
  while (true) {
    const auto comma = words.find(',');
    list.emplace_back(words.substr(0, comma));
    if (comma == std::string_view::npos) return list;
    words.remove_prefix(comma + 1);
  }
}

}  // namespace hecaton::device::universal_robots
