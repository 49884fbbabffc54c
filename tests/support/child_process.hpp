#pragma once
/// A program run by a test. It ends with the object, however the test ends.

#include <chrono>
#include <string>
#include <vector>

#include <sys/types.h>

namespace hecaton::test {

struct Exit {
  bool ended = false;  ///< false: still running after the wait
  int code = -1;       ///< −1 if a signal ended it
  int signal = 0;      ///< 0 if it returned
};

class ChildProcess {
 public:
  /// `program` is a file name in the build's bin folder, or an absolute path; its stdout and stderr go to files that
  /// output() reads.
  ChildProcess(const std::string& program, const std::vector<std::string>& arguments);
  ~ChildProcess();  ///< kills a running program; prints its stderr if the test has failed
  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&&) = delete;

  void signal(int number) const;
  /// Waits for its end, up to the limit.
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
