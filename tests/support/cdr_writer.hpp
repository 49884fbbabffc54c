#pragma once
/// Messages as bytes that a test writes by hand.

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace hecaton::test {

/// Plain CDR: each number stands at a multiple of its size behind the encapsulation.
class CdrWriter {
 public:
  explicit CdrWriter(bool little = true)
      : little_(little), bytes_{0, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0} {}

  template <class T>
  CdrWriter& number(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_.push_back(0);
    std::vector<std::uint8_t> raw(sizeof(T));
    std::memcpy(raw.data(), &value, sizeof(T));
    if (!little_) std::reverse(raw.begin(), raw.end());
    bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    return *this;
  }
  CdrWriter& text(const std::string& value) {
    number(static_cast<std::uint32_t>(value.size() + 1));
    bytes_.insert(bytes_.end(), value.begin(), value.end());
    bytes_.push_back(0);
    return *this;
  }
  CdrWriter& numbers(const std::vector<double>& values) {
    number(static_cast<std::uint32_t>(values.size()));
    for (const double value : values) number(value);
    return *this;
  }
  /// Without their count.
  CdrWriter& numbers_of(const std::vector<double>& values) {
    for (const double value : values) number(value);
    return *this;
  }
  [[nodiscard]] const std::vector<std::uint8_t>& bytes() const { return bytes_; }

 private:
  bool little_;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace hecaton::test
