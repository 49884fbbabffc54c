#pragma once
/// The registry of motion methods for the reader of cell files and the command line.

#include <functional>

#include "planner/methods/motion_method.hpp"

namespace hecaton::planner {

/// A value. A program with own methods copies built_in_methods(), adds its methods, and loads its cell with the copy.
class MethodRegistry {
 public:
  /// Makes a method with default parameters.
  using Make = std::function<std::shared_ptr<MotionMethod>()>;

  /// Throws std::invalid_argument if a method of the same name exists.
  void add(const Make& make);
  /// The same for a method without arguments.
  template <class Method>
  void add() {
    add([] { return std::make_shared<Method>(); });
  }

  /// In the order of their registration.
  [[nodiscard]] const std::vector<MethodTraits>& traits() const { return traits_; }
  [[nodiscard]] std::vector<std::string_view> names() const;  ///< in the order of their registration
  /// One method of each kind, with default parameters.
  [[nodiscard]] std::vector<std::shared_ptr<MotionMethod>> make_all() const;

 private:
  std::vector<Make> makers_;
  std::vector<MethodTraits> traits_;
};

/// The methods of Hecaton. Thread-safe.
[[nodiscard]] const MethodRegistry& built_in_methods();

/// A built-in method with default parameters. Throws std::invalid_argument with a list of names for an unknown name.
[[nodiscard]] std::shared_ptr<const MotionMethod> built_in_method(std::string_view name);

}  // namespace hecaton::planner
