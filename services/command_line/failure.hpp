#pragma once
/// A command that ends early.

#include <stdexcept>
#include <string>

#include "services/runtime/exit_code.hpp"

namespace hecaton::services::cli {

/// what() is the one sentence that people read; empty where another process says it.
class Failure : public std::runtime_error {
 public:
  Failure(ExitCode code, const std::string& sentence) : std::runtime_error(sentence), code_(code) {}
  [[nodiscard]] ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace hecaton::services::cli
