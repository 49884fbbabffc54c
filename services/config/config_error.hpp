#pragma once
/// A rejected cell file.

#include <stdexcept>
#include <string>

namespace hecaton::config {

/// what() is one sentence: file, key path, value, and what is allowed.
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace hecaton::config
