#include "services/arm_driver/device_test.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "planner/trajectory/stop_profile.hpp"
#include "services/arm_driver/device_probe.hpp"

namespace hecaton::services {
namespace {

using planner::JointState;
using planner::JointVector;
using Clock = device::Clock;

constexpr const char* kNode = "device-test";
/// For connections, and for programs on the controller.
constexpr double kReadyLimit = 30.0;  // [s]
/// A joint that stands is measured within this distance, and a joint that follows is as close to its set-point, beside
/// its lag [rad | m].
constexpr double kTolerance = 1e-3;
/// A joint within this distance of its rest position has stopped [rad | m].
constexpr double kAtRest = 2e-4;
/// Time in which a fault shows: a jump after activation, a motion after a stop [s].
constexpr double kObservation = 0.5;
/// An arm that a person stops, or that fails a check, has stopped after this time [s].
constexpr double kStopLimit = 2.0;
/// Shares of the limits of velocity and acceleration that the test uses.
constexpr double kGentle = 0.25;
/// A set-point that must be refused is farther than allowed by this factor.
constexpr double kTooFar = 1.5;

double seconds(Clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}
std::string milliseconds(double time) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f ms", time * 1e3);
  return text;
}

/// The value that a share `p` of the values does not exceed [s]. Zero without values.
double quantile(std::vector<std::chrono::nanoseconds>& values, double p) {
  if (values.empty()) return 0.0;
  const auto rank = static_cast<std::size_t>(std::ceil(p * static_cast<double>(values.size())));
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(rank, 1) - 1);
  std::nth_element(values.begin(), nth, values.end());
  return seconds(*nth);
}

/// q(t) = from + delta (1 − cos ωt) / 2: begins at rest, is fastest at ωt = π/2, at from + delta for ωt = π, and back
/// at 2π.
struct Motion {
  JointVector from;
  JointVector delta;
  double omega = 0.0;  ///< [rad/s]

  [[nodiscard]] JointState at(double t) const {
    return {from + delta * (0.5 * (1.0 - std::cos(omega * t))), delta * (0.5 * omega * std::sin(omega * t))};
  }
  [[nodiscard]] JointVector fastest() const { return delta.cwiseAbs() * (0.5 * omega); }
  [[nodiscard]] double until_fastest() const { return 0.5 * std::numbers::pi / omega; }
  [[nodiscard]] double until_there() const { return std::numbers::pi / omega; }
  [[nodiscard]] double until_back() const { return 2.0 * std::numbers::pi / omega; }
};

/// The test ends early: a person ended it, the device has failed or stopped, or a check of a motion has failed.
struct Ended {};

class DeviceTest {
 public:
  DeviceTest(const DeviceTestSetup& setup, device::ArmDevice& device, DriverPeriods& periods)
      : setup_(setup),
        periods_(periods),
        joints_(setup.control.limits.lower.size()),
        probe_(device, joints_, setup.control.period, [&periods] { return periods.now(); }) {
    const double timeout = setup.control.command_timeout;
    report_.checks = {
        {"measures", "is ready and measures every joint", "s", 0.0, kReadyLimit},
        {"state_age", "the measured state is fresh", "s", 0.0, timeout},
        {"activation", "begins where it stands", "rad", 0.0, kTolerance},
        {"tracking", "follows a slow motion of each joint", "rad"},
        {"commands_cease", "stops when commands cease", "s"},
        {"writes_cease", "stops by itself when set-points cease", "s"},
        {"stale_lease", "stands when a stale lease commands it", "rad", 0.0, kTolerance},
        {"far_set_point", "stands when a set-point is too far", "rad", 0.0, kTolerance},
        {"states", "reports its states and stays ready", ""},
        {"period", "reads and writes within a period (p99)", "s", 0.0, seconds(setup.control.period)},
        {"rest", "stands at the end, without set-points", "rad", 0.0, kTolerance},
    };
  }

  DeviceTestReport run() {
    try {
      connect();
      begin();
      track();
      cease_commands();
      cease_writes();
      refuse_stale_lease();
      refuse_far_set_point();
      go_back();
    } catch (const Ended&) {
      halt();
    }
    stand();
    conclude();
    return std::move(report_);
  }

 private:
  DeviceCheck& check(std::string_view name) {
    return *std::find_if(report_.checks.begin(), report_.checks.end(),
                         [&](const auto& one) { return one.name == name; });
  }
  /// Ends the check with this value; it fails, too, when `holds` is false. A failed check ends the motions.
  void judge(std::string_view name, double measured, bool holds = true, const std::string& details = {}) {
    DeviceCheck& one = check(name);
    one.measured = measured;
    const bool ok = holds && measured <= one.limit;
    one.result = ok ? CheckResult::kOk : CheckResult::kFailed;
    one.details = details;
    if (!ok) throw Ended();
  }
  void progress(std::string_view text) const {
    if (setup_.progress) setup_.progress(text);
  }

  /// One period of the driver without its end.
  void begin_period() {
    const Clock::time_point before = std::exchange(now_, periods_.next());
    if (before != Clock::time_point()) report_.longest_gap = std::max(report_.longest_gap, seconds(now_ - before));
    late_.push_back(periods_.late());
    control_->read(now_);
    control_->set_hold(hold_);
  }
  /// One period of the driver, with a command or without. Throws Ended when a person ends the test, or the device has
  /// failed or stopped.
  void period(const msg::ArmCommand* command = nullptr) {
    begin_period();
    if (command != nullptr) judgement_ = control_->command(*command);
    control_->write();
    if (periods_.ended()) throw Ended();
    if (follows_ && !probe_.active()) {
      lost_ = control_->cause().text();
      throw Ended();
    }
  }
  void wait(double time) {
    const Clock::time_point begin = now_;
    while (seconds(now_ - begin) < time) period();
  }

  [[nodiscard]] msg::ArmCommand command_to(const JointState& target) {
    msg::ArmCommand command;
    command.node(kNode);
    command.term(term_);
    command.sequence_number(++sequence_);
    command.period(setup_.control_period);
    command.q({target.q.begin(), target.q.end()});
    command.qd({target.qd.begin(), target.qd.end()});
    return command;
  }

  /// Commands the motion for `time` [s], once a control period. Calls `each()` in each period. A stall of this machine
  /// delays the motion, so that no set-point jumps.
  template <class Each>
  void move(const Motion& motion, double time, Each each) {
    double t = 0.0;
    double due = 0.0;
    while (t < time) {
      std::optional<msg::ArmCommand> command;
      if (t >= due - 1e-9) {
        command = command_to(motion.at(std::min(time, t + setup_.control_period)));
        due = t + setup_.control_period;
      }
      const Clock::time_point before = now_;
      period(command ? &*command : nullptr);
      if (command && judgement_.verdict != Verdict::kAccepted) {
        lost_ = judgement_.cause.text();
        throw Ended();
      }
      each();
      t += before == Clock::time_point() ? 0.0 : std::min(seconds(now_ - before), setup_.control_period);
    }
  }
  void move(const Motion& motion, double time) {
    move(motion, time, [] {});
  }

  [[nodiscard]] const JointVector& measured() const { return probe_.measured().q; }

  /// A new driver begins with the device.
  void connect_driver() {
    follows_ = false;
    control_.reset();
    control_ = std::make_unique<ArmControl>(setup_.control, probe_);
  }
  /// Waits until `event`. False after kReadyLimit.
  template <class Event>
  bool until(Event event) {
    const Clock::time_point begin = now_;
    std::string before;
    while (!event()) {
      if (seconds(now_ - begin) > kReadyLimit) return false;
      period();
      const std::string text = control_->cause().text();
      if (text != before) progress(text);
      before = text;
    }
    return true;
  }

  void connect() {
    connect_driver();
    hold_ = make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, setup_.control.arm, "waits for its device");
    period();
    const Clock::time_point began = now_;
    const bool ready = until([&] { return probe_.ready(); });
    judge("measures", seconds(now_ - began), ready, ready ? "" : control_->cause().text());
    start_ = measured();
    choose_directions();
  }

  /// Each joint moves away from its nearer limit.
  void choose_directions() {
    const auto& limits = setup_.control.limits;
    directions_ = JointVector::Ones(joints_);
    for (Eigen::Index j = 0; j < joints_; ++j) {
      const double up = limits.upper[j] - start_[j];
      const double down = start_[j] - limits.lower[j];
      if (up < down) directions_[j] = -1.0;
      if (std::max(up, down) >= 1.1 * setup_.distance) continue;
      check("tracking").result = CheckResult::kFailed;
      check("tracking").details = "joint " + std::to_string(j + 1) + " has no " + number(setup_.distance) +
                                  " rad (m) to move between its limits";
      throw Ended();
    }
  }

  /// A motion within a share of the limits. `delta` is not zero.
  [[nodiscard]] Motion motion(const JointVector& delta) const {
    const auto& limits = setup_.control.limits;
    Motion motion{measured(), delta, 2.0 * std::numbers::pi / setup_.duration};
    for (Eigen::Index j = 0; j < joints_; ++j) {
      const double half = 0.5 * std::abs(delta[j]);
      if (half == 0.0) continue;
      motion.omega = std::min(
          {motion.omega, kGentle * limits.velocity[j] / half, std::sqrt(kGentle * limits.acceleration[j] / half)});
    }
    return motion;
  }
  [[nodiscard]] JointVector all(double sign) const { return directions_ * (sign * setup_.distance); }

  /// The arm follows from now on, from where it stands.
  void activate() {
    hold_.reset();
    const bool active = until([&] { return probe_.active() && probe_.ready(); });
    if (!active) judge("activation", 0.0, false, control_->cause().text());
    follows_ = true;
    wait(kObservation);
    judge("activation", probe_.jump());
    probe_.release();
  }

  void begin() {
    progress("activates the device");
    activate();
  }

  struct Tracked {
    double error = 0.0;   ///< largest distance of a joint from its set-point
    double travel = 0.0;  ///< of the set-points
    int counted = 0;
    int all = 0;
  };
  /// How the arm follows the set-points of a motion. A stall of this machine delays the motion, and after it the driver
  /// continues from where the arm is: the set-points that were written count, not those of the motion.
  Tracked follow(const Motion& motion) {
    Tracked tracked;
    move(motion, motion.until_back(), [&] {
      ++tracked.all;
      const auto wanted = probe_.wanted();
      if (!wanted) return;
      ++tracked.counted;
      tracked.error = std::max(tracked.error, (measured() - *wanted).cwiseAbs().maxCoeff());
      tracked.travel = std::max(tracked.travel, (*wanted - motion.from).cwiseAbs().maxCoeff());
    });
    return tracked;
  }

  void track() {
    DeviceCheck& tracking = check("tracking");
    const double scaling = control_->speed_scaling();
    if (scaling < 0.999) {
      judge("tracking", 0.0, false,
            "the controller executes " + number(100.0 * scaling) + " % of the speed: set 100 %");
    }
    double worst = -1.0;  // share of the limit
    for (Eigen::Index j = 0; j < joints_; ++j) {
      progress("moves joint " + std::to_string(j + 1));
      JointVector delta = JointVector::Zero(joints_);
      delta[j] = directions_[j] * setup_.distance;
      const Motion there_and_back = motion(delta);
      const Tracked tracked = follow(there_and_back);
      const double peak = tracked.error;
      if (2 * tracked.counted < tracked.all || tracked.travel < 0.5 * setup_.distance)
        judge("tracking", 0.0, false, "this machine stalls too often to measure it");
      const double lag = seconds(setup_.control.period) + control_->tracking_delay();
      const double limit = there_and_back.fastest()[j] * lag + kTolerance;
      if (peak / limit > worst) {
        worst = peak / limit;
        tracking.measured = peak;
        tracking.limit = limit;
        tracking.details = "joint " + std::to_string(j + 1);
      }
      if (worst > 1.0) break;
      wait(kObservation);
    }
    judge("tracking", tracking.measured, true, std::string(tracking.details));
  }

  /// Watches the arm for `watched` [s], with `step` in each period. Returns the time until its rest [s].
  template <class Step>
  double time_to_rest(double watched, Step step) {
    struct Sample {
      double at;  ///< [s]
      JointVector q;
    };
    std::vector<Sample> samples;
    const Clock::time_point begin = now_;
    while (seconds(now_ - begin) < watched) {
      step();
      samples.push_back({seconds(probe_.measured_at() - begin), measured()});
    }
    const JointVector rest = samples.back().q;
    const auto moved = std::find_if(samples.rbegin(), samples.rend(), [&](const Sample& sample) {
      return (sample.q - rest).cwiseAbs().maxCoeff() > kAtRest;
    });
    return moved == samples.rend() ? 0.0 : std::max(0.0, moved->at);
  }
  /// Time from silence to rest in the fastest part of a motion. A lag τ is that of a servo of first order: its error
  /// v τ e^(−t/τ) is kAtRest after t = τ ln(v τ / kAtRest).
  [[nodiscard]] double stop_limit(double silence, const Motion& motion) const {
    const double lag = control_->tracking_delay();
    const double behind = motion.fastest().maxCoeff() * lag;
    return silence + planner::stop_time(setup_.control.limits, motion.fastest()) +
           lag * (1.0 + std::log(std::max(1.0, behind / kAtRest))) + 2.0 * seconds(setup_.control.period);
  }

  void cease_commands() {
    progress("moves all joints, then commands cease");
    const Motion forth = motion(all(1.0));
    move(forth, forth.until_fastest());
    DeviceCheck& ceased = check("commands_cease");
    ceased.limit = stop_limit(setup_.control.command_timeout, forth);
    const double time = time_to_rest(ceased.limit + kObservation, [&] { period(); });
    const bool explained = control_->cause().kind() == msg::CauseKind::CAUSE_COMMANDS_CEASED;
    judge("commands_cease", time, explained, explained ? "by the driver" : control_->cause().text());
  }

  // The device may report its stop, or stay ready.
  void cease_writes() {
    progress("moves all joints, then set-points cease");
    const Motion back = motion(all(-1.0));
    move(back, back.until_fastest());
    follows_ = false;
    DeviceCheck& ceased = check("writes_cease");
    ceased.limit = stop_limit(seconds(setup_.control.valid_for), back);
    const double time = time_to_rest(ceased.limit + kObservation, [&] {
      begin_period();
      if (periods_.ended()) throw Ended();
    });
    judge("writes_cease", time);
    progress("configures and activates the device again");
    connect_driver();
    activate();
  }

  /// The largest distance from where the arm stands, while it receives this command.
  double moved_by(const msg::ArmCommand& command) {
    const JointVector stands = measured();
    double most = 0.0;
    period(&command);
    const Judgement judgement = judgement_;
    for (const Clock::time_point begin = now_; seconds(now_ - begin) < kObservation;) {
      period();
      most = std::max(most, (measured() - stands).cwiseAbs().maxCoeff());
    }
    judgement_ = judgement;
    return most;
  }

  void refuse_stale_lease() {
    progress("commands with a stale lease");
    const std::uint64_t stale = term_++;
    control_->observe_lease({kNode, term_});
    msg::ArmCommand command = command_to({measured() + all(1.0), JointVector::Zero(joints_)});
    command.term(stale);
    const double moved = moved_by(command);
    judge("stale_lease", moved, judgement_.verdict == Verdict::kStaleTerm, judgement_.cause.text());
  }

  void refuse_far_set_point() {
    progress("commands a set-point that is too far");
    const double late = setup_.control.command_timeout + setup_.control_period + control_->tracking_delay();
    const JointVector far = setup_.control.limits.velocity.cwiseProduct(directions_) * (kTooFar * late);
    const double moved = moved_by(command_to({measured() + far, JointVector::Zero(joints_)}));
    judge("far_set_point", moved, judgement_.verdict == Verdict::kTooFar, judgement_.cause.text());
  }

  void go_back() {
    progress("moves back to the start");
    const JointVector delta = start_ - measured();
    if (delta.cwiseAbs().maxCoeff() < kTolerance) return;
    const Motion there = motion(delta);
    move(there, there.until_there());
    wait(kObservation);
  }

  /// Stops the arm on the driver's stop profile, also when a person ends the test.
  void halt() {
    hold_ = make_cause(msg::CauseKind::CAUSE_HOLD_ORDERED, setup_.control.arm, "the test has ended");
    const Clock::time_point begin = now_;
    while (probe_.active() && seconds(now_ - begin) < kStopLimit) {
      begin_period();
      control_->write();
      const msg::ArmMode mode = control_->mode();
      if (mode != msg::ArmMode::ARM_RUNNING && mode != msg::ArmMode::ARM_BRAKING) break;
    }
  }

  /// The device is deactivated; then it is only read.
  void stand() {
    const bool stops = probe_.active() && !periods_.ended();
    control_.reset();
    if (!stops) return;
    progress("watches the arm stand");
    JointVector stands;
    double most = 0.0;
    for (const Clock::time_point begin = now_; seconds(now_ - begin) < 2.0 * kObservation;) {
      now_ = periods_.next();
      (void)probe_.read(now_);
      if (periods_.ended()) return;
      if (measured().size() != joints_) continue;
      if (seconds(now_ - begin) < kObservation || stands.size() == 0) stands = measured();
      most = std::max(most, (measured() - stands).cwiseAbs().maxCoeff());
    }
    DeviceCheck& rest = check("rest");
    rest.measured = most;
    rest.result = most <= rest.limit ? CheckResult::kOk : CheckResult::kFailed;
  }

  void conclude() {
    const auto end = [&](std::string_view name, double measured, bool ok, const std::string& details) {
      DeviceCheck& one = check(name);
      one.measured = measured;
      one.result = ok ? CheckResult::kOk : CheckResult::kFailed;
      one.details = details;
    };
    if (check("measures").result != CheckResult::kOk) return;
    DeviceCheck& age = check("state_age");
    const double oldest = seconds(probe_.oldest());
    const bool fresh = oldest <= age.limit;
    end("state_age", oldest, fresh, "");
    // A state that is too old is the failure, and what follows from it is not.
    if (!fresh && check("activation").result == CheckResult::kFailed) check("activation") = untested("activation");
    const std::string& broken = probe_.violation().empty() && fresh ? lost_ : probe_.violation();
    if (!broken.empty() || probe_.activations() > 0) {
      end("states", 0.0, broken.empty(),
          broken.empty() ? "activated " + std::to_string(probe_.activations()) + " times" : broken);
    }
    judge_durations();
  }
  /// A machine that stalls interrupts calls of the device as often as waits. That share of the longest calls says
  /// nothing of the device: where nothing stalls, none.
  void judge_durations() {
    std::vector<std::chrono::nanoseconds> durations = probe_.durations();
    if (durations.empty()) return;
    const auto stalls =
        std::count_if(late_.begin(), late_.end(), [&](const auto& late) { return late > setup_.control.period; });
    const double stalled = static_cast<double>(stalls) / static_cast<double>(late_.size());
    DeviceCheck& period = check("period");
    period.measured = quantile(durations, std::max(0.5, 0.99 - stalled));
    period.result = period.measured <= period.limit ? CheckResult::kOk : CheckResult::kFailed;
    period.details =
        "p50 " + milliseconds(quantile(durations, 0.5)) + ", longest " + milliseconds(quantile(durations, 1.0));
    if (stalls > 0) period.details += ", without " + number(100.0 * stalled) + " % for stalls of this machine";
  }
  DeviceCheck untested(std::string_view name) {
    DeviceCheck one = check(name);
    one.measured = 0.0;
    one.result = CheckResult::kNotTested;
    one.details.clear();
    return one;
  }

  const DeviceTestSetup& setup_;
  DriverPeriods& periods_;
  Eigen::Index joints_;
  DeviceProbe probe_;
  DeviceTestReport report_;
  std::unique_ptr<ArmControl> control_;
  std::optional<msg::Cause> hold_;
  Clock::time_point now_;
  std::vector<std::chrono::nanoseconds> late_;  ///< wake-ups of this machine
  JointVector start_;
  JointVector directions_;  ///< ±1
  std::uint64_t term_ = 1;
  std::uint64_t sequence_ = 0;
  Judgement judgement_;   ///< of the last command
  bool follows_ = false;  ///< the device shall stay active
  std::string lost_;      ///< why the device does not follow any more
};

}  // namespace

bool DeviceTestReport::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const auto& one) { return one.result == CheckResult::kOk; });
}

int DeviceTestReport::tested() const {
  return static_cast<int>(std::count_if(checks.begin(), checks.end(),
                                        [](const auto& one) { return one.result != CheckResult::kNotTested; }));
}

DeviceTestReport test_device(const DeviceTestSetup& setup, device::ArmDevice& device, DriverPeriods& periods) {
  return DeviceTest(setup, device, periods).run();
}

}  // namespace hecaton::services
