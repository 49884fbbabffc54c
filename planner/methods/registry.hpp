#pragma once
/// Which motion methods there are: the cell file's reader, the command line and the documents' tests ask here.

#include <functional>

#include "planner/methods/motion_method.hpp"

namespace hecaton::planner {

/// A value: a program that has methods of its own copies built_in_methods(), adds them, and loads its cell with that.
class MethodRegistry {
 public:
  using Make = std::function<std::shared_ptr<MotionMethod>()>;

  /// Throws std::invalid_argument when there is a method of the same name.
  void add(const Make& make);
  template <class Method>
  void add() {
    add([] { return std::make_shared<Method>(); });
  }

  /// In the order of their registration.
  [[nodiscard]] const std::vector<MethodTraits>& traits() const { return traits_; }
  [[nodiscard]] std::vector<std::string_view> names() const;
  /// One of each, with default parameters.
  [[nodiscard]] std::vector<std::shared_ptr<MotionMethod>> make_all() const;

 private:
  std::vector<Make> makers_;
  std::vector<MethodTraits> traits_;
};

/// Those of Hecaton. Thread-safe.
[[nodiscard]] const MethodRegistry& built_in_methods();

/// A built-in method with default parameters. Throws std::invalid_argument that lists the names when there is none.
[[nodiscard]] std::shared_ptr<const MotionMethod> built_in_method(std::string_view name);

}  // namespace hecaton::planner
