#pragma once
/// Reads the keys of `device:` in the cell file.

#include <optional>
#include <string>
#include <string_view>

#include "services/arm_driver/devices/arm_device.hpp"

namespace hecaton::device {

/// The values of a device's keys. Throws std::runtime_error with a sentence (key, value, what is allowed) when one
/// cannot be used.
class OptionReader {
 public:
  /// `setup` must outlive it.
  explicit OptionReader(const DeviceSetup& setup) : setup_(setup) {}

  /// Empty: the cell file does not have the key.
  [[nodiscard]] std::optional<std::string> text(std::string_view key) const;
  /// An IPv4 address.
  [[nodiscard]] std::optional<std::string> address(std::string_view key) const;
  /// `unit`: "s" accepts 50ms and 0.05s, too.
  [[nodiscard]] double number(std::string_view key, double otherwise, double least, double most,
                              const std::string& unit = "") const;
  [[nodiscard]] int whole_number(std::string_view key, int otherwise, int least, int most) const;

  [[noreturn]] void fail(std::string_view key, const std::string& value, const std::string& rule) const;

 private:
  const DeviceSetup& setup_;
};

}  // namespace hecaton::device
