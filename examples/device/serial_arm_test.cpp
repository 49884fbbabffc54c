// The example plug-in in a live cell, with an arm on a pseudo-terminal.
#include <array>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include "services/runtime/cause.hpp"
#include "tests/cell/motion/motion_cell.hpp"

namespace hecaton::test {
namespace {

constexpr int kJoints = 6;

/// The arm at the other end of the line; its position is the last set-point.
class ArmOnALine {
 public:
  explicit ArmOnALine(const std::vector<double>& q) : q_(q), qd_(kJoints, 0.0), thread_([this] { run(); }) {}
  ~ArmOnALine() {
    ends_ = true;
    thread_.join();
    ::close(slave_);
    ::close(master_);
  }
  ArmOnALine(const ArmOnALine&) = delete;
  ArmOnALine& operator=(const ArmOnALine&) = delete;

  [[nodiscard]] const std::string& port() const { return port_; }
  /// Empty: ends the failure.
  void fail(const std::optional<std::string>& what) {
    const std::lock_guard lock(mutex_);
    failure_ = what;
  }
  /// A defect: without set-points it goes on at its last velocity.
  void coast() { coasts_ = true; }
  [[nodiscard]] std::vector<double> q() {
    const std::lock_guard lock(mutex_);
    return q_;
  }

 private:
  static int open_master() {
    const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (master < 0 || ::grantpt(master) != 0 || ::unlockpt(master) != 0) throw std::runtime_error("no pseudo-terminal");
    return master;
  }

  void run() {
    pollfd line{master_, POLLIN, 0};
    while (!ends_) {
      if (::poll(&line, 1, 2) > 0) receive();
      if (coasts_) go_on();
      send();
    }
  }

  void receive() {
    std::array<char, 4096> bytes;
    for (ssize_t n = 0; (n = ::read(master_, bytes.data(), bytes.size())) > 0;) received_.append(bytes.data(), n);
    for (std::size_t end = 0; (end = received_.find('\n')) != std::string::npos; received_.erase(0, end + 1)) {
      obey(received_.substr(0, end));
    }
  }

  void obey(const std::string& line) {
    std::istringstream words(line);
    char kind = 0;
    std::vector<double> q(kJoints), qd(kJoints);
    words >> kind;
    for (double& value : q) words >> value;
    for (double& value : qd) words >> value;
    const std::lock_guard lock(mutex_);
    if (kind == 'M' && words) {
      q_ = q;
      qd_ = qd;
    } else {
      qd_.assign(kJoints, 0.0);
    }
  }

  void go_on() {
    constexpr double kPoll = 0.002;  // [s]
    const std::lock_guard lock(mutex_);
    for (std::size_t joint = 0; joint < q_.size(); ++joint) q_[joint] += qd_[joint] * kPoll;
  }

  void send() {
    std::ostringstream line;
    line.precision(9);
    {
      const std::lock_guard lock(mutex_);
      if (failure_) {
        line << "F " << *failure_;
      } else {
        line << 'S';
        for (const double q : q_) line << ' ' << q;
        for (const double qd : qd_) line << ' ' << qd;
      }
    }
    const std::string text = line.str() + '\n';
    (void)!::write(master_, text.data(), text.size());  // fails if no driver reads
  }

  int master_ = open_master();
  std::string port_ = ::ptsname(master_);
  int slave_ = ::open(port_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);  // keeps the line open without a driver
  std::string received_;
  std::mutex mutex_;
  std::optional<std::string> failure_;
  std::vector<double> q_, qd_;
  std::atomic<bool> ends_ = false, coasts_ = false;
  std::thread thread_;
};

struct WithArm {
  ArmOnALine arm_on_a_line{{0, -1.9, 2.6, 0, 0.6, 0}};
};

class SerialArmTest : public WithArm, public MotionCell {
 protected:
  SerialArmTest()
      : MotionCell(1, "", "  device: {type: serial, plugin: libserial_arm.so, port: " + arm_on_a_line.port() + "}\n") {}
};

TEST_F(SerialArmTest, ReachesGoal) {
  start_all();
  send(joint_goal("over there", kReady));
  ASSERT_TRUE(await([this] { return is("over there", msg::GoalState::GOAL_REACHED); }));
  const std::vector<double> q = arm_on_a_line.q();
  for (int j = 0; j < kJoints; ++j) EXPECT_NEAR(q[j], kReady[j], 0.02) << j;
}

TEST_F(SerialArmTest, FailureHoldsTheArmUntilItEnds) {
  start_all();
  arm_on_a_line.fail("joint 3: overcurrent");
  // On a busy machine the state may be too old first, which is a failure, too.
  ASSERT_TRUE(await([this] { return arm()->cause().text().starts_with("joint 3: overcurrent"); }));
  EXPECT_EQ(arm()->mode(), msg::ArmMode::ARM_FAILED);
  EXPECT_EQ(arm()->cause().kind(), msg::CauseKind::CAUSE_DEVICE_FAILED);
  EXPECT_EQ(arm()->cause().subject(), "arm1");
  arm_on_a_line.fail({});
  ASSERT_TRUE(await([this] { return arm()->mode() != msg::ArmMode::ARM_FAILED; }));
  // The supervisor holds the arm for the fault until a person resumes it.
  msg::ArmOrder hold;
  hold.arm("arm1");
  hold.mode(msg::Mode::MODE_HOLD);
  hold.cause(services::make_cause(msg::CauseKind::CAUSE_HELD_BY_FAULT, "arm1", "the arm failed"));
  mode_.arms({hold});
  ASSERT_TRUE(await([this] { return arm()->cause().kind() == msg::CauseKind::CAUSE_HELD_BY_FAULT; }));
  mode_.arms({});
  ASSERT_TRUE(await([this] { return arm()->mode() == msg::ArmMode::ARM_RUNNING; }));
}

// So slow that the arm of this test may come late by some milliseconds on a busy machine.
TEST_F(SerialArmTest, PassesTheDeviceTest) {
  ChildProcess test("hecaton", {"device-test", path_, "arm1", "--yes", "--distance", "0.02", "--duration", "4s"});
  EXPECT_EQ(test.wait(kLimit).code, 0) << test.standard_output();
}

TEST_F(SerialArmTest, FailsTheDeviceTestWhenItGoesOnWithoutSetPoints) {
  arm_on_a_line.coast();
  ChildProcess test("hecaton", {"device-test", path_, "arm1", "--yes", "--distance", "0.1", "--duration", "4s"});
  EXPECT_EQ(test.wait(kLimit).code, 1) << test.standard_output();
  const std::string table = test.standard_output();
  const std::size_t check = table.find("stops by itself when set-points cease");
  ASSERT_NE(check, std::string::npos) << table;
  EXPECT_NE(table.substr(check, table.find('\n', check) - check).find("FAILED"), std::string::npos) << table;
}

TEST_F(SerialArmTest, RejectsUnknownDeviceKey) {
  ChildProcess driver("hecaton-arm-driver", {HECATON_SOURCE_DIR "/examples/device/wrong_key.yaml", "--arm", "left"});
  EXPECT_EQ(driver.wait(kLimit).code, 3);
  EXPECT_NE(driver.standard_error().find("arms[0].device.prt is not a known key; did you mean 'port'?"),
            std::string::npos)
      << driver.standard_error();
}

}  // namespace
}  // namespace hecaton::test
