#pragma once
/// Where the logs of a cell that `up` starts go.

#include <string>

namespace hecaton::services::cli {

class LogFolder {
 public:
  /// `wanted`, made if missing; empty: a new folder among the temporary ones. Throws Failure (bad input).
  LogFolder(const std::string& wanted, const std::string& cell);
  /// Removes a temporary folder unless it was asked to stay.
  ~LogFolder();
  LogFolder(const LogFolder&) = delete;
  LogFolder& operator=(const LogFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] bool temporary() const { return temporary_; }
  /// All went well: the logs tell nothing.
  void discard() { discard_ = temporary_; }

 private:
  std::string path_;
  bool temporary_ = false;
  bool discard_ = false;
};

}  // namespace hecaton::services::cli
