#pragma once
/// A bus_peer as a child process.

#include <array>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace hecaton::bus {

struct PeerOptions {
  int lease_ms = 2000;   ///< of the participant
  bool unicast = false;  ///< discovery through 127.0.0.1 instead of multicast
};

class PeerProcess {
 public:
  PeerProcess(const std::string& role, int domain, const std::string& name, const PeerOptions& options = {}) {
    std::array<int, 2> input{};
    std::array<int, 2> output{};
    if (::pipe2(input.data(), O_CLOEXEC) != 0 || ::pipe2(output.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("no pipe for bus_peer");
    }
    const std::string program = HECATON_BIN_DIR "/bus_peer";
    std::vector<std::string> words{program, role, std::to_string(domain), name, std::to_string(options.lease_ms)};
    if (options.unicast) words.emplace_back("unicast");
    std::vector<char*> arguments;
    for (auto& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, input[0], STDIN_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, output[1], STDOUT_FILENO);
    const int error = ::posix_spawn(&pid_, arguments[0], &actions, nullptr, arguments.data(), environ);
    ::posix_spawn_file_actions_destroy(&actions);
    ::close(input[0]);
    ::close(output[1]);
    input_ = input[1];
    output_ = output[0];
    if (error != 0) throw std::runtime_error("cannot start " + words[0]);
  }
  ~PeerProcess() {
    ::close(input_);
    ::close(output_);
    send(SIGCONT);
    if (pid_ > 0) ::waitpid(pid_, nullptr, 0);
  }
  PeerProcess(const PeerProcess&) = delete;
  PeerProcess& operator=(const PeerProcess&) = delete;

  void send(int signal) const {
    if (pid_ > 0) ::kill(pid_, signal);
  }
  /// Sends SIGKILL and waits for the end.
  void kill() {
    send(SIGKILL);
    ::waitpid(std::exchange(pid_, -1), nullptr, 0);
  }
  /// The next line of its stdout; empty at the end.
  [[nodiscard]] std::string line() const {
    std::string text;
    for (char byte = 0; ::read(output_, &byte, 1) == 1 && byte != '\n';) text += byte;
    return text;
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
};

}  // namespace hecaton::bus
