#pragma once
/// The records of the file format MCAP (https://mcap.dev/spec), as bytes. All numbers are little-endian. Standard
/// library and zlib only.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <zlib.h>

namespace hecaton::services::recorder {

/// A recording that cannot be written or read. what() is one sentence: file, reason, what to do.
class RecordingError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;
using StringMap = std::map<std::string, std::string>;

/// At both ends of a file.
inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', 0x30, '\r', '\n'};

/// First byte of a record. The length of its body follows as 64 bits.
enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kAttachment = 0x09,
  kAttachmentIndex = 0x0A,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

inline constexpr std::size_t kRecordHead = 9;  ///< opcode and length [byte]

/// CRC-32 (IEEE 802.3) of `bytes`, continued from the CRC of what stands before them.
[[nodiscard]] inline std::uint32_t crc32_of(ByteSpan bytes, std::uint32_t before = 0) {
  auto crc = static_cast<uLong>(before);
  while (!bytes.empty()) {
    const std::size_t part = std::min<std::size_t>(bytes.size(), std::numeric_limits<uInt>::max());
    crc = ::crc32(crc, bytes.data(), static_cast<uInt>(part));
    bytes = bytes.subspan(part);
  }
  return static_cast<std::uint32_t>(crc);
}

/// Appends values to bytes.
class ByteWriter {
 public:
  explicit ByteWriter(Bytes& bytes) : bytes_(bytes) {}

  template <class T>
  ByteWriter& number(T value) {
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i)));
    }
    return *this;
  }
  ByteWriter& bytes(ByteSpan data) {
    bytes_.insert(bytes_.end(), data.begin(), data.end());
    return *this;
  }
  ByteWriter& text(std::string_view value) {
    number(static_cast<std::uint32_t>(value.size()));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    return *this;
  }
  ByteWriter& map(const StringMap& values) {
    std::size_t size = 0;
    for (const auto& [key, value] : values) size += 8 + key.size() + value.size();
    number(static_cast<std::uint32_t>(size));
    for (const auto& [key, value] : values) text(key).text(value);
    return *this;
  }
  /// 16-bit keys with 64-bit values.
  ByteWriter& map(const std::map<std::uint16_t, std::uint64_t>& values) {
    number(static_cast<std::uint32_t>(values.size() * 10));
    for (const auto& [key, value] : values) number(key).number(value);
    return *this;
  }

 private:
  Bytes& bytes_;
};

/// Reads values out of bytes. Throws std::out_of_range when they are cut off.
class ByteReader {
 public:
  explicit ByteReader(ByteSpan bytes) : bytes_(bytes) {}

  template <class T>
  [[nodiscard]] T number() {
    std::uint64_t value = 0;
    const ByteSpan raw = bytes(sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) value |= static_cast<std::uint64_t>(raw[i]) << (8 * i);
    return static_cast<T>(value);
  }
  [[nodiscard]] ByteSpan bytes(std::uint64_t size) {
    if (size > bytes_.size() - at_) throw std::out_of_range("the record is cut off");
    const ByteSpan part = bytes_.subspan(at_, static_cast<std::size_t>(size));
    at_ += static_cast<std::size_t>(size);
    return part;
  }
  [[nodiscard]] std::string text() {
    const ByteSpan raw = bytes(number<std::uint32_t>());
    return {raw.begin(), raw.end()};
  }
  [[nodiscard]] StringMap map() {
    ByteReader inner(bytes(number<std::uint32_t>()));
    StringMap values;
    while (inner.left() > 0) {
      std::string key = inner.text();
      values[std::move(key)] = inner.text();
    }
    return values;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }
  [[nodiscard]] std::size_t at() const { return at_; }

 private:
  ByteSpan bytes_;
  std::size_t at_ = 0;
};

}  // namespace hecaton::services::recorder
