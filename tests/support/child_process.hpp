#pragma once
/// A real program run by a test. It is gone when the object is, however the test ends.

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

namespace hecaton::test {

struct Exit {
  bool ended = false;  ///< false: still running when the wait was over
  int code = -1;       ///< −1 when a signal ended it
  int signal = 0;      ///< 0 when it returned
};

class ChildProcess {
 public:
  /// `program` is a file name in the build's bin folder; its stdout and stderr go to files that output() reads.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments);
  ~ChildProcess();  ///< kills it when it still runs; prints its stderr when the test has failed
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  void signal(int number) const;
  /// Waits for its end.
  Exit wait(std::chrono::milliseconds limit);
  [[nodiscard]] pid_t pid() const { return pid_; }
  [[nodiscard]] std::string standard_output() const;
  [[nodiscard]] std::string standard_error() const;

 private:
  std::string program_;
  std::string stem_;  ///< of the output files
  pid_t pid_ = -1;
  Exit exit_;
};

}  // namespace hecaton::test
