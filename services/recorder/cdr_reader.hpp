#pragma once
/// Reads plain CDR of either byte order.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <stdexcept>
#include <string>

#include "services/recorder/mcap_format.hpp"

namespace hecaton::services::recorder {

/// Functions throw std::out_of_range when the message is cut off.
class CdrReader {
 public:
  static constexpr std::size_t kEncapsulation = 4;

  /// `message`: with its encapsulation.
  explicit CdrReader(ByteSpan message)
      : bytes_(message.subspan(kEncapsulation)),
        swapped_((message[1] == 1) != (std::endian::native == std::endian::little)) {}

  template <class T>
  T number() {
    const std::size_t begin = (at_ + sizeof(T) - 1) & ~(sizeof(T) - 1);
    if (begin + sizeof(T) > bytes_.size()) throw std::out_of_range("cut off");
    std::array<std::uint8_t, sizeof(T)> raw{};
    std::memcpy(raw.data(), bytes_.data() + begin, sizeof(T));
    if (swapped_) std::reverse(raw.begin(), raw.end());
    at_ = begin + sizeof(T);
    return std::bit_cast<T>(raw);
  }
  std::string text() {
    const ByteSpan raw = text_bytes();
    return raw.empty() ? std::string() : std::string(reinterpret_cast<const char*>(raw.data()), raw.size() - 1);
  }
  void skip_text() { static_cast<void>(text_bytes()); }
  /// A text with the 0 at its end, as it stands in the message.
  ByteSpan text_bytes() {
    const auto size = number<std::uint32_t>();
    if (size > left()) throw std::out_of_range("cut off");
    at_ += size;
    return bytes_.subspan(at_ - size, size);
  }

  /// Behind the encapsulation.
  [[nodiscard]] std::size_t at() const { return at_; }
  void move_to(std::size_t at) { at_ = at; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  ByteSpan bytes_;
  bool swapped_;
  std::size_t at_ = 0;
};

}  // namespace hecaton::services::recorder
