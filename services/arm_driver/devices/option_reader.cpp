#include "services/arm_driver/devices/option_reader.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include <arpa/inet.h>

namespace hecaton::device {
namespace {

std::string range(double least, double most, const std::string& unit) {
  char text[64];
  std::snprintf(text, sizeof text, "%g%s to %g%s", least, unit.c_str(), most, unit.c_str());
  return text;
}

}  // namespace

std::optional<std::string> OptionReader::text(std::string_view key) const {
  const auto found = setup_.values.find(key);
  return found == setup_.values.end() ? std::nullopt : std::optional(found->second);
}

void OptionReader::fail(std::string_view key, const std::string& value, const std::string& rule) const {
  throw std::runtime_error(setup_.where + "." + std::string(key) + " = " + value + " must be " + rule);
}

std::optional<std::string> OptionReader::address(std::string_view key) const {
  auto value = text(key);
  in_addr parsed{};
  if (value && ::inet_pton(AF_INET, value->c_str(), &parsed) != 1) {
    fail(key, *value, "an IPv4 address, such as 192.168.0.10");
  }
  return value;
}

double OptionReader::number(std::string_view key, double otherwise, double least, double most,
                            const std::string& unit) const {
  const auto value = text(key);
  if (!value) return otherwise;
  double number = 0.0;
  const char* const end = value->data() + value->size();
  const auto [rest, error] = std::from_chars(value->data(), end, number);
  const std::string_view suffix(rest, static_cast<std::size_t>(end - rest));
  const bool milli = unit == "s" && suffix == "ms";
  const bool known = suffix.empty() || milli || (unit == "s" && suffix == "s");
  if (milli) number *= 1e-3;
  const bool allowed = error == std::errc() && known && number >= least && number <= most;
  if (!allowed) fail(key, *value, range(least, most, unit));
  return number;
}

int OptionReader::whole_number(std::string_view key, int otherwise, int least, int most) const {
  const double value = number(key, otherwise, least, most);
  if (value != std::floor(value)) fail(key, *text(key), "a whole number");
  return static_cast<int>(value);
}

}  // namespace hecaton::device
