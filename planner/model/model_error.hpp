#pragma once
/// The error of everything that reads a robot's description from files.

#include <stdexcept>

namespace hecaton::planner {

/// Bad URDF, SRDF or mesh. what() is one sentence that names file, element, value and what is allowed.
class ModelError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace hecaton::planner
