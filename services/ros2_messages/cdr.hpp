#pragma once
/// Plain CDR (XCDR version 1, little-endian), the encoding of ROS 2. A message is a struct with a static function
/// `fields(self, visit)` that calls `visit` with all members in their order.
///
/// Decoding checks every length against the bytes that are left before it takes memory. It accepts a message only when
/// nothing is left behind it. So it refuses a request with the 16 bytes that rmw_cyclonedds puts before the body.

#include <array>
#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace hecaton::ros2 {

using Bytes = std::vector<std::uint8_t>;

static_assert(std::endian::native == std::endian::little, "encoding copies numbers as they are in memory");

namespace cdr {

/// CDR, little-endian, without options.
inline constexpr std::array<std::uint8_t, 4> kEncapsulation{0, 1, 0, 0};

template <class T>
concept Number = std::is_arithmetic_v<T>;

class Encoder {
 public:
  explicit Encoder(Bytes& out) : out_(out) { out_.assign(kEncapsulation.begin(), kEncapsulation.end()); }

  template <class... T>
  void operator()(const T&... values) {
    (put(values), ...);
  }

 private:
  void align(std::size_t size) {
    const std::size_t past = (out_.size() - kEncapsulation.size()) % size;
    if (past != 0) out_.resize(out_.size() + size - past);
  }
  void put_bytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    out_.insert(out_.end(), bytes, bytes + size);
  }
  template <Number T>
  void put(const T& value) {
    align(sizeof(T));
    put_bytes(&value, sizeof(T));
  }
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    put_bytes(text.c_str(), text.size() + 1);
  }
  template <class T>
  void put(const std::vector<T>& items) {
    put(static_cast<std::uint32_t>(items.size()));
    for (const T& item : items) put(item);
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& items) {
    for (const T& item : items) put(item);
  }
  template <class T>
  requires requires(const T& value, Encoder& encoder) { T::fields(value, encoder); }
  void put(const T& value) { T::fields(value, *this); }

  Bytes& out_;
};

class Decoder {
 public:
  /// `bytes`: with encapsulation.
  explicit Decoder(std::span<const std::uint8_t> bytes)
      : bytes_(bytes), ok_(bytes.size() >= 4 && bytes[0] == 0 && bytes[1] == 1), at_(kEncapsulation.size()) {}

  template <class... T>
  void operator()(T&... values) {
    (get(values), ...);
  }
  /// Everything was read and the padding of the whole is all that is left.
  [[nodiscard]] bool complete() const { return ok_ && bytes_.size() - at_ < 4; }

 private:
  [[nodiscard]] std::size_t left() const { return ok_ ? bytes_.size() - at_ : 0; }
  const std::uint8_t* next(std::size_t size) {
    ok_ = ok_ && size <= left();
    if (!ok_) return nullptr;
    at_ += size;
    return bytes_.data() + at_ - size;
  }
  template <Number T>
  void get(T& value) {
    const std::size_t past = (at_ - kEncapsulation.size()) % sizeof(T);
    if (past != 0) next(sizeof(T) - past);
    const std::uint8_t* from = next(sizeof(T));
    if (from == nullptr) return;
    if constexpr (std::is_same_v<T, bool>) {
      value = *from != 0;
    } else {
      std::memcpy(&value, from, sizeof(T));
    }
  }
  void get(std::string& text) {
    std::uint32_t size = 0;
    get(size);
    const std::uint8_t* from = next(size);
    if (from != nullptr && size > 0) text.assign(reinterpret_cast<const char*>(from), size - 1);
  }
  /// The vector grows with what is read: each item takes at least one byte.
  template <class T>
  void get(std::vector<T>& items) {
    std::uint32_t count = 0;
    get(count);
    if constexpr (Number<T>) {
      ok_ = ok_ && count <= left() / sizeof(T);
    } else {
      ok_ = ok_ && count <= left();
    }
    items.clear();
    for (std::uint32_t i = 0; ok_ && i < count; ++i) get(items.emplace_back());
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& items) {
    for (T& item : items) get(item);
  }
  template <class T>
  requires requires(T& value, Decoder& decoder) { T::fields(value, decoder); }
  void get(T& value) { T::fields(value, *this); }

  std::span<const std::uint8_t> bytes_;
  bool ok_;
  std::size_t at_;
};

}  // namespace cdr

/// Writes the message into `out`, which is reused memory.
template <class Message>
void encode(const Message& message, Bytes& out) {
  cdr::Encoder encoder(out);
  encoder(message);
}

template <class Message>
[[nodiscard]] Bytes encoded(const Message& message) {
  Bytes bytes;
  encode(message, bytes);
  return bytes;
}

/// Empty when the bytes are not exactly one message.
template <class Message>
[[nodiscard]] std::optional<Message> decoded(std::span<const std::uint8_t> bytes) {
  std::optional<Message> message(std::in_place);
  cdr::Decoder decoder(bytes);
  decoder(*message);
  if (!decoder.complete()) message.reset();
  return message;
}

}  // namespace hecaton::ros2
