#pragma once
/// A program of tests/robots that plays the controller of a robot, with orders on a loopback address of its own.

#include <chrono>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/support/child_process.hpp"

namespace hecaton::test {

class RobotSimulator {
 public:
  using Json = nlohmann::json;

  /// Returns when the controller listens. `program`: of tests/robots, a Python file there or a program of the build.
  explicit RobotSimulator(const std::vector<std::string>& options = {}, const std::string& program = "ur_controller.py")
      : process_(program.ends_with(".py") ? HECATON_SOURCE_DIR "/tests/robots/" + program : program,
                 arguments(options)) {
    for (int tries = 0; tries < 600 && !connect(); ++tries) ::usleep(50'000);  // until it listens
    EXPECT_GE(socket_, 0) << "the controller does not start: " << process_.standard_error();
  }
  ~RobotSimulator() { ::close(socket_); }
  RobotSimulator(const RobotSimulator&) = delete;
  RobotSimulator& operator=(const RobotSimulator&) = delete;

  [[nodiscard]] const std::string& address() const { return address_; }
  [[nodiscard]] const ChildProcess& process() const { return process_; }

  /// Gives an order (the methods of Orders in the program) and returns the answer.
  Json order(const std::string& line) {
    const std::string text = line + "\n";
    EXPECT_EQ(::send(socket_, text.data(), text.size(), MSG_NOSIGNAL), static_cast<ssize_t>(text.size()));
    std::string answer;
    for (char byte = 0; ::recv(socket_, &byte, 1, 0) == 1 && byte != '\n';) answer += byte;
    return Json::parse(answer, nullptr, false);
  }
  [[nodiscard]] Json state() { return order("state"); }

 private:
  // Each process has its own network of loopback addresses, so that tests can run at the same time.
  static std::string new_address() {
    static int count = 0;
    const int pid = ::getpid();
    return "127." + std::to_string(1 + ++count) + "." + std::to_string(pid / 250 % 250) + "." +
           std::to_string(1 + pid % 250);
  }
  std::vector<std::string> arguments(const std::vector<std::string>& options) const {
    std::vector<std::string> all{"--address", address_};
    all.insert(all.end(), options.begin(), options.end());
    return all;
  }
  bool connect() {
    constexpr int kControlPort = 30999;
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(kControlPort);
    ::inet_pton(AF_INET, address_.c_str(), &to.sin_addr);
    socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return true;
    ::close(socket_);
    socket_ = -1;
    return false;
  }

  std::string address_ = new_address();
  ChildProcess process_;
  int socket_ = -1;
};

}  // namespace hecaton::test
