/// Simulates an arm in ros2_control on the network: joint_state_broadcaster, and a forward controller of positions or
/// velocities, or a joint trajectory controller, whose trajectories come by topic or by action; also the controller of
/// a gripper. It uses Cyclone DDS (for actions: action_server.hpp), and shares no code with the driver. Its sources are
/// the definitions of the messages and the documentation of the controllers.
///
/// usage: ros2_controller --joints NAME,… [OPTION…]. The options are those of the struct Options.
///
/// Tests give orders on TCP port 30999 of the address, and people on the standard input: a line each, answered by a
/// line of JSON. The orders are those of Robot::order(). The hardware is a servo of first order for each joint.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/robots/ros2_robot.hpp"

namespace {

using namespace hecaton::test::ros2;

constexpr std::uint16_t kControlPort = 30999;

/// Lines from the standard input and from TCP.
class Orders {
 public:
  explicit Orders(const std::string& address) : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const int on = 1;
    ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in own{};
    own.sin_family = AF_INET;
    own.sin_port = htons(kControlPort);
    ::inet_pton(AF_INET, address.c_str(), &own.sin_addr);
    if (::bind(listener_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 || ::listen(listener_, 5) != 0) {
      throw std::runtime_error("cannot listen on " + address + ": " + std::strerror(errno));
    }
    lines_[STDIN_FILENO];
  }

  /// Takes orders until then.
  void serve(Robot& robot, Steady::time_point until) {
    while (true) {
      std::vector<pollfd> files{{listener_, POLLIN, 0}};
      for (const auto& [file, text] : lines_) files.push_back({file, POLLIN, 0});
      const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Steady::now()).count();
      const timespec timeout{0, std::max<std::int64_t>(0, left)};
      if (::ppoll(files.data(), files.size(), &timeout, nullptr) <= 0) return;
      if (files.front().revents != 0) lines_[::accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC)];
      for (std::size_t i = 1; i < files.size(); ++i) {
        if (files[i].revents != 0) read(robot, files[i].fd);
      }
    }
  }

 private:
  void read(Robot& robot, int file) {
    char bytes[512];
    const ssize_t count = ::read(file, bytes, sizeof bytes);
    if (count <= 0) {
      if (file != STDIN_FILENO) ::close(file);
      lines_.erase(file);
      return;
    }
    std::string& text = lines_[file].append(bytes, static_cast<std::size_t>(count));
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1)) {
      std::string answer;
      try {
        answer = robot.order(text.substr(0, end)).dump() + "\n";
      } catch (const std::exception& error) {
        answer = Json{{"error", error.what()}}.dump() + "\n";
      }
      [[maybe_unused]] const auto written =
          ::write(file == STDIN_FILENO ? STDOUT_FILENO : file, answer.data(), answer.size());
    }
  }

  int listener_;
  std::map<int, std::string> lines_;
};

Names split(const std::string& text) {
  Names parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) parts.push_back(part);
  return parts;
}

Options read(const Names& words) {
  Options options;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const auto value = [&]() -> const std::string& {
      if (i + 1 >= words.size()) throw std::runtime_error(word + " needs a value");
      return words[++i];
    };
    if (word == "--domain") {
      options.domain = std::stoi(value());
    } else if (word == "--namespace") {
      options.ns = value();
    } else if (word == "--controller") {
      options.controller = value();
    } else if (word == "--kind") {
      options.action = value() == "action";
      options.by_velocity = words[i] == "velocity";
      options.trajectory = options.action || words[i] == "trajectory";
    } else if (word == "--gripper") {
      options.gripper = value();
    } else if (word == "--finger") {
      options.finger = value();
    } else if (word == "--joints") {
      options.joints = split(value());
    } else if (word == "--others") {
      options.others = split(value());
    } else if (word == "--start") {
      for (const std::string& q : split(value())) options.start.push_back(std::stod(q));
    } else if (word == "--rate") {
      options.rate = std::stod(value());
    } else if (word == "--lag") {
      options.lag = std::stod(value());
    } else if (word == "--from-desired") {
      options.from_desired = true;
    } else if (word == "--keeps-velocity") {
      options.keeps_velocity = true;
    } else if (word == "--no-velocity") {
      options.velocity = false;
    } else if (word == "--scaling-topic") {
      options.scaling_topic = value();
    } else if (word == "--key-hash") {
      ::setenv("CYCLONEDDS_URI", "<Internal><GenerateKeyhash>true</GenerateKeyhash></Internal>", 1);
    } else if (word == "--address") {
      options.address = value();
    } else {
      throw std::runtime_error("no option " + word);
    }
  }
  if (options.joints.empty()) throw std::runtime_error("--joints NAME,… is needed");
  if (options.controller.empty()) {
    options.controller = options.trajectory    ? "joint_trajectory_controller"
                         : options.by_velocity ? "forward_velocity_controller"
                                               : "forward_position_controller";
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const Options options = read({argv + 1, argv + argc});
    Robot robot(options);
    Orders orders(options.address);
    std::printf("controller %s in domain %d, orders on %s\n", options.controller.c_str(), options.domain,
                options.address.c_str());
    std::fflush(stdout);
    const auto period = std::chrono::duration_cast<Steady::duration>(std::chrono::duration<double>(1.0 / options.rate));
    for (auto due = Steady::now();;) {
      robot.cycle();
      // An arm that a velocity moves goes on also while this machine stalls.
      due = options.by_velocity ? due + period : std::max(due + period, Steady::now() - 10 * period);
      orders.serve(robot, due);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "ros2_controller: %s\n", error.what());
    return 1;
  }
}
