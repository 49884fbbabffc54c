#include "services/config/duration.hpp"

#include <array>

#include "services/config/text.hpp"

namespace hecaton::config {
namespace {

struct Unit {
  std::string_view name;
  double per_second;  // how many make a second: dividing keeps 10ms = 0.01 exactly
};
// Longer names first: "ms" also ends in "s".
constexpr std::array<Unit, 6> kUnits = {
    {{"min", 1.0 / 60.0}, {"ns", 1e9}, {"us", 1e6}, {"µs", 1e6}, {"ms", 1e3}, {"s", 1.0}}};

}  // namespace

std::optional<double> parse_duration(std::string_view text) {
  for (const Unit& unit : kUnits) {
    if (!text.ends_with(unit.name)) continue;
    std::string_view number = text.substr(0, text.size() - unit.name.size());
    while (!number.empty() && number.back() == ' ') number.remove_suffix(1);
    const auto value = parse_number(number);
    if (!value) return std::nullopt;
    return *value / unit.per_second;
  }
  return std::nullopt;
}

}  // namespace hecaton::config
