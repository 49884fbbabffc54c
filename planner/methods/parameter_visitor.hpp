#pragma once
/// Access to the parameters of methods: one call for each key of the cell file. The reader of cell files sets values;
/// other visitors list the keys.

#include <cmath>
#include <initializer_list>
#include <limits>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>

namespace hecaton::planner {

/// The allowed values of a number.
struct ParameterRange {
  double low = -std::numeric_limits<double>::infinity();  ///< least value
  double high = std::numeric_limits<double>::infinity();  ///< greatest value
  std::string_view unit = "";                             ///< for messages
  bool low_open = false;                                  ///< low itself is not allowed
};

/// Names have static storage duration. A visitor overrides the functions that it needs.
class ParameterVisitor {
 public:
  virtual ~ParameterVisitor() = default;
  /// Begins a map of an arm in the cell file; the following parameters belong to it. Methods may share a map.
  virtual void section(std::string_view /*key*/) {}
  /// Default of all functions below.
  virtual void key(std::string_view /*name*/) {}

  /// A number with a unit.
  virtual void number(std::string_view name, double& /*value*/, const ParameterRange& /*range*/) { key(name); }
  /// A duration [s].
  virtual void seconds(std::string_view name, double& /*value*/, const ParameterRange& /*range*/) { key(name); }
  /// A whole number, low to high.
  virtual void integer(std::string_view name, int& /*value*/, int /*low*/, int /*high*/) { key(name); }
  /// True or false.
  virtual void boolean(std::string_view name, bool& /*value*/) { key(name); }
  /// A list of up to values.size() numbers; `count`: the number of values.
  virtual void numbers(std::string_view name, std::span<double> /*values*/, int& /*count*/,
                       const ParameterRange& /*range*/) {
    key(name);
  }
  /// A YAML file with such a section for each arm. It then provides the keys `said_there`.
  virtual void file(std::string_view name, std::initializer_list<std::string_view> /*said_there*/) { key(name); }
  /// One of the words; `index`: its position.
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

/// The text that MotionMethod::validate returns, such as "follower.exit_fraction = 1 must be below 1".
[[nodiscard]] inline std::string must_be(std::string_view key, double value, const std::string& rule) {
  std::ostringstream out;
  out << key << " = " << value << " must be " << rule;
  return out.str();
}
/// A rule that refers to another key, such as "below influence_distance = 0.1".
[[nodiscard]] inline std::string compared(const char* relation, std::string_view key, double value) {
  std::ostringstream out;
  out << relation << ' ' << key << " = " << value;
  return out.str();
}

}  // namespace hecaton::planner
