#pragma once
/// How methods show their parameters: one call for each key of the cell file. The reader of cell files sets them,
/// others list the keys.

#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

namespace hecaton::planner {

struct ParameterRange {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::string_view unit = "";
  bool low_open = false;  ///< low itself is not allowed
};

/// Names have static storage duration. A visitor overrides what it is interested in.
class ParameterVisitor {
 public:
  virtual ~ParameterVisitor() = default;
  /// The parameters that follow belong to this map of an arm in the cell file. Methods may share a map.
  virtual void section(std::string_view /*key*/) {}
  /// Any of the following.
  virtual void key(std::string_view /*name*/) {}

  virtual void number(std::string_view name, double& /*value*/, const ParameterRange& /*range*/) { key(name); }
  /// A duration [s].
  virtual void seconds(std::string_view name, double& /*value*/, const ParameterRange& /*range*/) { key(name); }
  virtual void integer(std::string_view name, int& /*value*/, int /*low*/, int /*high*/) { key(name); }
  virtual void boolean(std::string_view name, bool& /*value*/) { key(name); }
  /// A list of up to values.size() numbers; `count`: how many there are.
  virtual void numbers(std::string_view name, std::span<double> /*values*/, int& /*count*/,
                       const ParameterRange& /*range*/) {
    key(name);
  }
  /// The key names a YAML file that has such a section for each arm, and which then says what the keys `said_there`
  /// say.
  virtual void file(std::string_view name, std::initializer_list<std::string_view> /*said_there*/) { key(name); }
  /// One of the words, as its index.
  virtual void word(std::string_view name, std::span<const std::string_view> /*words*/, std::size_t& /*index*/) {
    key(name);
  }
  /// The same for an enumeration with the values 0, 1, … in the words' order.
  template <class Enum>
  void choice(std::string_view name, std::span<const std::string_view> words, Enum& value) {
    auto index = static_cast<std::size_t>(value);
    word(name, words, index);
    value = static_cast<Enum>(index);
  }
};

/// "follower.exit_fraction = 1 must be below 1": what MotionMethod::validate returns.
[[nodiscard]] inline std::string must_be(std::string_view key, double value, const std::string& rule) {
  std::ostringstream out;
  out << key << " = " << value << " must be " << rule;
  return out.str();
}
/// "below influence_distance = 0.1", "no shorter than …"
[[nodiscard]] inline std::string compared(const char* relation, std::string_view key, double value) {
  std::ostringstream out;
  out << relation << ' ' << key << " = " << value;
  return out.str();
}

}  // namespace hecaton::planner
