// A device plug-in: an arm on a serial line with a text protocol.
//
//     arm → driver   S q₁ … qₙ q̇₁ … q̇ₙ      measured state [rad], [rad/s], every few milliseconds
//                    F description           instead of a state while the arm has failed
//     driver → arm   M q₁ … qₙ q̇₁ … q̇ₙ ms   set-point for the end of the period; stop without a successor within ms
//                    H                       stop
//
// Key in the cell file: `port`, the path of the serial line.
#include <cerrno>
#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include "services/arm_driver/devices/plugin.hpp"

using namespace hecaton::device;

namespace {

class SerialArm final : public ArmDevice {
 public:
  SerialArm(std::string port, Eigen::Index joints) : port_(std::move(port)), joints_(joints) {}
  ~SerialArm() override { close(); }

  DeviceResult configure() override {
    close();
    line_ = ::open(port_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (line_ < 0) return DeviceFailure{port_ + ": " + std::strerror(errno) + "; is the arm connected?"};
    termios settings{};
    ::tcgetattr(line_, &settings);
    ::cfmakeraw(&settings);
    ::cfsetspeed(&settings, B115200);
    ::tcsetattr(line_, TCSANOW, &settings);
    state_ = {};
    state_.text = port_ + ": no state received yet; is the arm switched on?";
    return {};
  }

  DeviceResult activate() override { return {}; }

  DeviceState read(Clock::time_point now) override {
    char bytes[4096];
    for (ssize_t n = 0; (n = ::read(line_, bytes, sizeof bytes)) > 0;) received_.append(bytes, n);
    for (std::size_t end = 0; (end = received_.find('\n')) != std::string::npos; received_.erase(0, end + 1)) {
      interpret(received_.substr(0, end), now);
    }
    state_.age = now - received_at_;
    return state_;
  }

  DeviceResult write(const JointState& set_point, std::chrono::nanoseconds valid_for) override {
    std::ostringstream line;
    line.precision(9);
    line << "M " << set_point.q.transpose() << ' ' << set_point.qd.transpose() << ' '
         << std::chrono::duration_cast<std::chrono::milliseconds>(valid_for).count() << '\n';
    return send(line.str());
  }

  void stop(std::string_view /*reason*/) override { (void)send("H\n"); }
  void deactivate() override {}

 private:
  // Ignores a truncated line; the next one arrives within milliseconds.
  void interpret(const std::string& line, Clock::time_point now) {
    std::istringstream words(line.substr(std::min<std::size_t>(2, line.size())));
    if (line.starts_with("F ")) {
      state_.mode = DeviceMode::kFailed;
      state_.text = words.str();
    } else if (line.starts_with("S ")) {
      JointState measured{JointVector(joints_), JointVector(joints_)};
      for (double& q : measured.q) words >> q;
      for (double& qd : measured.qd) words >> qd;
      if (!words) return;
      state_ = {measured, {}, 1.0, DeviceMode::kReady, {}};
      received_at_ = now;
    }
  }

  DeviceResult send(const std::string& line) const {
    if (line_ >= 0 && ::write(line_, line.data(), line.size()) == static_cast<ssize_t>(line.size())) return {};
    return DeviceFailure{port_ + ": cannot send to the arm: " + std::strerror(errno)};
  }

  void close() {
    if (line_ >= 0) ::close(line_);
    line_ = -1;
    received_.clear();
  }

  std::string port_;
  Eigen::Index joints_;
  int line_ = -1;
  std::string received_;
  DeviceState state_;
  Clock::time_point received_at_;
};

std::unique_ptr<ArmDevice> make_serial_arm(const DeviceSetup& setup) {
  const auto port = setup.values.find("port");
  if (port == setup.values.end()) {
    throw std::runtime_error(setup.where + ".port is missing; it must be the path of a serial line");
  }
  return std::make_unique<SerialArm>(port->second, setup.start.size());
}

}  // namespace

HECATON_DEVICE_PLUGIN({"serial", {"port"}, make_serial_arm})
