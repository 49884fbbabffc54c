#pragma once
/// RTPS datagrams as an intruder builds them: any number in any field. Little-endian.

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace hecaton::test {

class RtpsDatagram {
 public:
  using Prefix = std::array<std::uint8_t, 12>;
  static Prefix prefix() { return {1, 15, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}; }

  explicit RtpsDatagram(const Prefix& sender = prefix()) {
    for (const char c : {'R', 'T', 'P', 'S'}) bytes_.push_back(static_cast<std::uint8_t>(c));
    for (const int byte : {2, 2, 1, 15}) bytes_.push_back(static_cast<std::uint8_t>(byte));
    bytes_.insert(bytes_.end(), sender.begin(), sender.end());
  }

  /// The writer of the submessages that follow.
  RtpsDatagram& writer(std::uint32_t entity) {
    entity_ = entity;
    return *this;
  }
  RtpsDatagram& data(std::int64_t number, const std::vector<std::uint8_t>& payload = {}) {
    Body body;
    body.put16(0).put16(16).entity(0).entity(entity_).number(number);
    body.bytes.insert(body.bytes.end(), payload.begin(), payload.end());
    return submessage(0x15, body.bytes, payload.empty() ? 0 : 4);
  }
  /// A participant's announcement, with parameters: identifier and value.
  RtpsDatagram& announcement(const std::vector<std::pair<std::uint16_t, std::uint32_t>>& parameters,
                             std::uint8_t flags = 0) {
    Body body;
    body.put16(0).put16(16).entity(0x000100C7).entity(0x000100C2).number(1);
    if (parameters.empty()) return submessage(0x15, body.bytes, flags);
    for (const auto& [identifier, value] : parameters) body.put16(identifier).put16(4).put32(value);
    body.put16(1).put16(0);
    return submessage(0x15, body.bytes, flags | 2U);
  }
  /// A sample of discovery that speaks of `named`, behind `identifier` of its payload or, with `inlined`, before it.
  RtpsDatagram& discovery(std::int64_t number, std::uint16_t identifier, const Prefix& named, bool inlined = false) {
    Body body;
    body.put16(0).put16(16).entity(0).entity(entity_).number(number);
    if (!inlined) body.put16(0x0300).put16(0);
    body.put16(identifier).put16(16);
    body.bytes.insert(body.bytes.end(), named.begin(), named.end());
    body.entity(0x00000103).put16(1).put16(0);
    return submessage(0x15, body.bytes, inlined ? 2 : 4);
  }
  RtpsDatagram& fragment(std::int64_t number, std::uint32_t fragment, std::uint16_t fragments, std::uint16_t size,
                         std::uint32_t sample) {
    Body body;
    body.put16(0).put16(28).entity(0).entity(entity_).number(number);
    body.put32(fragment).put16(fragments).put16(size).put32(sample).put32(0);
    return submessage(0x16, body.bytes);
  }
  RtpsDatagram& heartbeat(std::int64_t first, std::int64_t last, std::uint32_t count = 1) {
    Body body;
    body.entity(0).entity(entity_).number(first).number(last).put32(count);
    return submessage(0x07, body.bytes);
  }
  RtpsDatagram& gap(std::int64_t first, std::int64_t end, std::uint32_t bits = 0) {
    Body body;
    body.entity(0).entity(entity_).number(first).number(end).put32(bits);
    body.bytes.resize(body.bytes.size() + std::min<std::size_t>((bits + 31) / 32, 8) * 4);
    return submessage(0x08, body.bytes);
  }
  RtpsDatagram& acknowledgement(std::int64_t base, std::uint32_t bits) {
    Body body;
    body.entity(0).entity(entity_).number(base).put32(bits);
    body.bytes.resize(body.bytes.size() + std::min<std::size_t>((bits + 31) / 32, 8) * 4);
    body.put32(1);
    return submessage(0x06, body.bytes);
  }
  RtpsDatagram& submessage(std::uint8_t id, const std::vector<std::uint8_t>& body, std::uint8_t flags = 0) {
    bytes_.push_back(id);
    bytes_.push_back(static_cast<std::uint8_t>(flags | 1U));
    bytes_.push_back(static_cast<std::uint8_t>(body.size()));
    bytes_.push_back(static_cast<std::uint8_t>(body.size() >> 8U));
    bytes_.insert(bytes_.end(), body.begin(), body.end());
    return *this;
  }

  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  struct Body {
    std::vector<std::uint8_t> bytes{};
    Body& put16(std::uint16_t value) {
      for (unsigned shift = 0; shift < 16; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
      return *this;
    }
    Body& put32(std::uint32_t value) {
      for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
      return *this;
    }
    Body& entity(std::uint32_t value) {
      for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
      return *this;
    }
    Body& number(std::int64_t value) {
      const auto raw = static_cast<std::uint64_t>(value);
      return put32(static_cast<std::uint32_t>(raw >> 32U)).put32(static_cast<std::uint32_t>(raw));
    }
  };

  std::uint32_t entity_ = 0x00000102;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace hecaton::test
