#include "services/arm_driver/devices/universal_robots/program.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string_view>
#include <utility>

#include "services/arm_driver/devices/universal_robots/rtde.hpp"

namespace hecaton::device::universal_robots {
namespace {

constexpr std::int32_t kSetPoint = 1;
constexpr std::int32_t kEnd = 2;
constexpr double kMicro = 1e6;
/// The servo follows with the lag of lookahead_time: after this many of it, 5 % of a distance are left.
constexpr double kLags = 3.0;

// The thread calls servoj in each cycle of the robot, so that packets may come early, late or in pairs. After a gap it
// catches up at twice the velocity limits. Where set-points cease, or the program ends, all joints stop together as in
// stop_profile.hpp. The thread goes on until the reference has been at rest for @SETTLE@ s: the servo has arrived then.
constexpr std::string_view kProgram = R"(def hecaton():
  global period = get_steptime()
  global limit = @VELOCITY@
  global braking = @ACCELERATION@
  global target = get_actual_joint_positions()
  global speed = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
  global silence = 0.0
  global valid = 0.0
  global follows = False

  thread servo():
    local axis = 0
    local change = 0.0
    local gap = 0.0
    local need = 0.0
    local slower = 1.0
    local stop = 0.0
    local rest = 0.0
    local reference = target
    while follows or rest < @SETTLE@:
      enter_critical
      silence = silence + period
      if silence > 1.5 * period:
        slower = 1.0
        if silence > valid:
          stop = period
          axis = 0
          while axis < 6:
            need = speed[axis] / braking[axis]
            if need < 0.0:
              need = 0.0 - need
            end
            if need > stop:
              stop = need
            end
            axis = axis + 1
          end
          slower = 1.0 - period / stop
        end
        axis = 0
        while axis < 6:
          speed[axis] = slower * speed[axis]
          target[axis] = target[axis] + speed[axis] * period
          axis = axis + 1
        end
      end
      rest = rest + period
      axis = 0
      while axis < 6:
        change = 2.0 * limit[axis] * period
        gap = target[axis] - reference[axis]
        if gap > change:
          gap = change
        elif gap < 0.0 - change:
          gap = 0.0 - change
        end
        if speed[axis] != 0.0 or gap > 0.000001 or gap < 0.0 - 0.000001:
          rest = 0.0
        end
        reference[axis] = reference[axis] + gap
        axis = axis + 1
      end
      exit_critical
      servoj(reference, 0, 0, period, @LOOKAHEAD@, @GAIN@)
    end
    stopj(@STOP@)
  end

  if socket_open("@ADDRESS@", @PORT@, "hecaton"):
    patience = 2.0
    goes_on = True
    while goes_on:
      packet = socket_read_binary_integer(15, "hecaton", patience)
      if packet[0] != 15:
        textmsg("hecaton: set-points ceased")
        goes_on = False
      elif packet[2] != 1:
        goes_on = False
      else:
        patience = packet[1] / 1000.0
        near = True
        enter_critical
        joint = 0
        while joint < 6:
          jump = packet[4 + joint] / 1000000.0 - target[joint]
          allowed = limit[joint] * (silence + 0.02)
          if jump > allowed or jump < 0.0 - allowed:
            near = False
          end
          joint = joint + 1
        end
        if near:
          joint = 0
          while joint < 6:
            target[joint] = packet[4 + joint] / 1000000.0
            speed[joint] = packet[10 + joint] / 1000000.0
            joint = joint + 1
          end
          silence = 0.0
          valid = packet[3] / 1000.0
        end
        exit_critical
        if not near:
          textmsg("hecaton: a set-point is too far from the last one")
          goes_on = False
        elif not follows:
          follows = True
          servo_thread = run servo()
        end
      end
    end
    if follows:
      enter_critical
      valid = 0.0
      follows = False
      exit_critical
      join servo_thread
    end
    socket_close("hecaton")
  else:
    textmsg("hecaton: cannot connect to the driver")
  end
end
)";

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6f", value);
  return text.data();
}

std::string list(const JointVector& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "[" : ", ") + number(value);
  return text + "]";
}

void replace(std::string& text, std::string_view word, const std::string& value) {
  const auto at = text.find(word);
  text.replace(at, word.size(), value);
}

std::int32_t micro(double value) {
  constexpr double kMost = 2.147e9;
  return static_cast<std::int32_t>(std::llround(std::clamp(value * kMicro, -kMost, kMost)));
}

std::int32_t whole_milliseconds(std::chrono::nanoseconds time) {
  return static_cast<std::int32_t>(std::chrono::ceil<std::chrono::milliseconds>(time).count());
}

std::string packet(std::int32_t timeout, std::int32_t kind, std::int32_t valid, const JointState& set_point) {
  std::string bytes;
  const auto put = [&](std::int32_t value) { put_u32(bytes, static_cast<std::uint32_t>(value)); };
  for (const std::int32_t value : {timeout, kind, valid}) put(value);
  for (const double q : set_point.q) put(micro(q));
  for (const double qd : set_point.qd) put(micro(qd));
  return bytes;
}

}  // namespace

std::string program_text(const ProgramSetup& setup) {
  std::string text(kProgram);
  for (const auto& [word, value] : {std::pair<std::string_view, std::string>{"@ADDRESS@", setup.address},
                                    {"@PORT@", std::to_string(setup.port)},
                                    {"@LOOKAHEAD@", number(setup.lookahead_time)},
                                    {"@GAIN@", number(setup.gain)},
                                    {"@SETTLE@", number(kLags * setup.lookahead_time)},
                                    {"@STOP@", number(setup.acceleration.minCoeff())},
                                    {"@VELOCITY@", list(setup.velocity)},
                                    {"@ACCELERATION@", list(setup.acceleration)}}) {
    replace(text, word, value);
  }
  return text;
}

std::string set_point_packet(const JointState& set_point, std::chrono::nanoseconds timeout,
                             std::chrono::nanoseconds valid_for) {
  return packet(whole_milliseconds(timeout), kSetPoint, whole_milliseconds(valid_for), set_point);
}

std::string end_packet() {
  return packet(0, kEnd, 0, {JointVector::Zero(6), JointVector::Zero(6)});
}

}  // namespace hecaton::device::universal_robots
