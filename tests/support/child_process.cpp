#include "tests/support/child_process.hpp"

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::test {
namespace {

std::string contents(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string new_stem() {
  static std::atomic<int> count{0};
  return (std::filesystem::temp_directory_path() /
          ("hecaton-test-" + std::to_string(getpid()) + "-" + std::to_string(count++)))
      .string();
}

}  // namespace

ChildProcess::ChildProcess(const std::string& program, const std::vector<std::string>& arguments)
    : program_(std::filesystem::path(program).filename()), stem_(new_stem()) {
  const std::string path = std::filesystem::path(HECATON_BIN_DIR) / program;
  const std::string out = stem_ + ".out";
  const std::string err = stem_ + ".err";
  std::vector<char*> argv{const_cast<char*>(path.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("fork failed");
  if (pid_ > 0) return;
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // also if the test crashes
  dup2(open(out.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDOUT_FILENO);
  dup2(open(err.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDERR_FILENO);
  execv(path.c_str(), argv.data());
  _exit(127);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : program_(std::move(other.program_)),
      stem_(std::exchange(other.stem_, {})),
      pid_(std::exchange(other.pid_, -1)),
      exit_(other.exit_) {}

ChildProcess::~ChildProcess() {
  if (stem_.empty()) return;
  if (!exit_.ended) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (testing::Test::HasFailure()) std::cerr << "--- " << program_ << " said:\n" << standard_error();
  std::filesystem::remove(stem_ + ".out");
  std::filesystem::remove(stem_ + ".err");
}

void ChildProcess::signal(int number) const {
  if (!exit_.ended) kill(pid_, number);
}

Exit ChildProcess::wait(std::chrono::milliseconds limit) {
  if (exit_.ended) return exit_;
  const int descriptor = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  pollfd ended{descriptor, POLLIN, 0};
  poll(&ended, 1, static_cast<int>(limit.count()));
  close(descriptor);
  int status = 0;
  if (waitpid(pid_, &status, WNOHANG) != pid_) return {};
  exit_ = {true, WIFEXITED(status) ? WEXITSTATUS(status) : -1, WIFSIGNALED(status) ? WTERMSIG(status) : 0};
  return exit_;
}

std::string ChildProcess::standard_output() const {
  return contents(stem_ + ".out");
}

std::string ChildProcess::standard_error() const {
  return contents(stem_ + ".err");
}

}  // namespace hecaton::test
