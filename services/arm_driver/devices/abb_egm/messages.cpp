#include "services/arm_driver/devices/abb_egm/messages.hpp"

#include <bit>
#include <cmath>
#include <cstring>

namespace hecaton::device::abb_egm {
namespace {

static_assert(std::endian::native == std::endian::little, "doubles are copied as they are on the wire");

enum class WireType : std::uint8_t { kVarint = 0, kFixed64 = 1, kBlock = 2, kFixed32 = 5 };

struct Field {
  std::uint64_t number = 0;
  WireType type = WireType::kVarint;
  std::uint64_t value = 0;  ///< of kVarint
  std::string_view bytes;   ///< of the other types
};

/// Goes through the fields of a message. Reads no byte outside of it.
class FieldReader {
 public:
  explicit FieldReader(std::string_view bytes) : rest_(bytes) {}

  /// False: the message ends here, or it is damaged.
  bool next() {
    if (rest_.empty() || damaged_) return false;
    damaged_ = !read();
    return !damaged_;
  }
  [[nodiscard]] const Field& field() const { return field_; }
  [[nodiscard]] bool damaged() const { return damaged_; }

 private:
  bool read() {
    std::uint64_t tag = 0;
    if (!read_varint(tag) || tag >> 3U == 0) return false;
    field_ = {tag >> 3U, static_cast<WireType>(tag & 7U), 0, {}};
    switch (field_.type) {
      case WireType::kVarint:
        return read_varint(field_.value);
      case WireType::kFixed64:
        return read_bytes(8);
      case WireType::kFixed32:
        return read_bytes(4);
      case WireType::kBlock: {
        std::uint64_t size = 0;
        return read_varint(size) && read_bytes(size);
      }
    }
    return false;
  }

  bool read_varint(std::uint64_t& value) {
    value = 0;
    for (unsigned shift = 0; shift < 64 && !rest_.empty(); shift += 7) {
      const auto byte = static_cast<unsigned char>(rest_.front());
      rest_.remove_prefix(1);
      value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if (byte < 0x80U) return true;
    }
    return false;
  }

  bool read_bytes(std::uint64_t size) {
    if (size > rest_.size()) return false;
    field_.bytes = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return true;
  }

  std::string_view rest_;
  Field field_;
  bool damaged_ = false;
};

/// Calls `take` for each field. False: the message is damaged, or `take` refuses a field.
template <typename Take>
bool for_each_field(std::string_view bytes, const Take& take) {
  FieldReader reader(bytes);
  while (reader.next()) {
    if (!take(reader.field())) return false;
  }
  return !reader.damaged();
}

bool read_number(const Field& field, std::optional<std::uint64_t>& value) {
  value = field.value;
  return field.type == WireType::kVarint;
}

bool add_double(std::string_view bytes, JointValues& values) {
  double value = 0.0;
  std::memcpy(&value, bytes.data(), sizeof value);
  return std::isfinite(value) && values.add(value);
}

// Repeated doubles come one by one, or packed into a block.
bool read_doubles(const Field& field, JointValues& values) {
  const bool repeated = field.type == WireType::kFixed64 || field.type == WireType::kBlock;
  if (!repeated || field.bytes.size() % sizeof(double) != 0) return false;
  for (std::size_t at = 0; at < field.bytes.size(); at += sizeof(double)) {
    if (!add_double(field.bytes.substr(at), values)) return false;
  }
  return true;
}

bool read_joints(const Field& field, JointValues& values) {
  return field.type == WireType::kBlock &&
         for_each_field(field.bytes, [&](const Field& part) { return part.number != 1 || read_doubles(part, values); });
}

// EgmClock: seconds and microseconds.
bool read_clock(const Field& field, std::optional<std::uint64_t>& clock_us) {
  std::optional<std::uint64_t> seconds, microseconds;
  const bool read = field.type == WireType::kBlock && for_each_field(field.bytes, [&](const Field& part) {
                      if (part.number == 1) return read_number(part, seconds);
                      return part.number != 2 || read_number(part, microseconds);
                    });
  if (!read || !seconds || !microseconds) return false;
  clock_us = *seconds * 1'000'000U + *microseconds;
  return true;
}

// EgmFeedBack.
bool read_feedback(const Field& field, RobotMessage& message) {
  return field.type == WireType::kBlock && for_each_field(field.bytes, [&](const Field& part) {
           switch (part.number) {
             case 1:
               return read_joints(part, message.joints);
             case 3:
               return read_joints(part, message.external);
             case 4:
               return read_clock(part, message.clock_us);
             default:
               return true;
           }
         });
}

struct Header {
  std::optional<std::uint64_t> sequence_number, sent_ms;
};

bool read_header(const Field& field, Header& header) {
  return field.type == WireType::kBlock && for_each_field(field.bytes, [&](const Field& part) {
           if (part.number == 1) return read_number(part, header.sequence_number);
           return part.number != 2 || read_number(part, header.sent_ms);
         });
}

// Each state is a message with one enumeration. Values of later versions are undefined here.
template <typename State>
bool read_state(const Field& field, State most, std::optional<State>& state) {
  std::optional<std::uint64_t> value;
  const bool read = field.type == WireType::kBlock && for_each_field(field.bytes, [&](const Field& part) {
                      return part.number != 1 || read_number(part, value);
                    });
  if (!read || !value) return false;
  state = *value <= static_cast<std::uint64_t>(most) ? static_cast<State>(*value) : State::kUndefined;
  return true;
}

/// Writes into a buffer that is large enough for every message.
class FieldWriter {
 public:
  explicit FieldWriter(SensorBuffer& buffer) : buffer_(buffer) {}

  void number(unsigned field, std::uint64_t value) {
    varint(field << 3U);
    varint(value);
  }
  /// A block of less than 128 bytes.
  template <typename Write>
  void block(unsigned field, const Write& write) {
    varint(field << 3U | 2U);
    const std::size_t length_at = size_++;
    write();
    buffer_[length_at] = static_cast<char>(size_ - length_at - 1);
  }
  void joints(unsigned field, const JointValues& joints) {
    block(field, [&] {
      for (const double value : joints.get()) {
        varint(1U << 3U | 1U);
        std::memcpy(&buffer_[size_], &value, sizeof value);
        size_ += sizeof value;
      }
    });
  }
  [[nodiscard]] std::string_view bytes() const { return {buffer_.data(), size_}; }

 private:
  void varint(std::uint64_t value) {
    for (; value > 0x7FU; value >>= 7U) buffer_[size_++] = static_cast<char>((value & 0x7FU) | 0x80U);
    buffer_[size_++] = static_cast<char>(value);
  }

  SensorBuffer& buffer_;
  std::size_t size_ = 0;
};

}  // namespace

std::optional<RobotMessage> decode(std::string_view bytes) {
  RobotMessage message;
  Header header;
  std::optional<MotorState> motors;
  std::optional<GuidanceState> guidance;
  std::optional<RapidState> rapid;
  std::optional<std::uint64_t> converged;
  const bool read = for_each_field(bytes, [&](const Field& field) {
    switch (field.number) {
      case 1:
        return read_header(field, header);
      case 2:
        return read_feedback(field, message);
      case 4:
        return read_state(field, MotorState::kOff, motors);
      case 5:
        return read_state(field, GuidanceState::kRunning, guidance);
      case 6:
        return read_number(field, converged);
      case 8:
        return read_state(field, RapidState::kRunning, rapid);
      default:
        return true;
    }
  });
  const bool complete = read && header.sequence_number && header.sent_ms && motors && guidance && rapid;
  if (!complete || message.joints.count + message.external.count == 0) return std::nullopt;
  message.sequence_number = static_cast<std::uint32_t>(*header.sequence_number);
  message.sent_ms = static_cast<std::uint32_t>(*header.sent_ms);
  message.motors = *motors;
  message.guidance = *guidance;
  message.rapid = *rapid;
  message.converged = converged.value_or(0) != 0;
  return message;
}

std::string_view encode(const SensorMessage& message, SensorBuffer& buffer) {
  constexpr std::uint64_t kCorrection = 3;
  FieldWriter writer(buffer);
  writer.block(1, [&] {
    writer.number(1, message.sequence_number);
    writer.number(2, message.sent_ms);
    writer.number(3, kCorrection);
  });
  writer.block(2, [&] {
    writer.joints(1, message.joints);
    if (message.external.count > 0) writer.joints(3, message.external);
  });
  return writer.bytes();
}

}  // namespace hecaton::device::abb_egm
