/// hecaton device-test: whether the device of an arm keeps the contract of ArmDevice.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iostream>
#include <memory>
#include <thread>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "services/arm_driver/control_setup.hpp"
#include "services/arm_driver/device_choice.hpp"
#include "services/arm_driver/device_test.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/long_work.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/cell_file.hpp"
#include "services/config/text.hpp"
#include "services/runtime/periodic_loop.hpp"
#include "services/runtime/thread_priority.hpp"

namespace hecaton::services::cli {
namespace {

struct DeviceTestOptions {
  std::string cell;
  std::string arm;
  double distance = 0.05;
  double duration = 2.0;
  bool yes = false;
};

/// On the deadlines of a driver. A person ends them with a signal.
class LivePeriods final : public DriverPeriods {
 public:
  LivePeriods(std::chrono::nanoseconds period, const Interruption& interruption)
      : period_(period), interruption_(interruption) {}

  [[nodiscard]] Clock::time_point next() override {
    const Clock::time_point before = Clock::now();
    due_ = next_deadline(due_, before, period_).at;
    std::this_thread::sleep_until(due_);
    const Clock::time_point now = Clock::now();
    late_ = due_ > before ? now - due_ : Clock::duration::zero();
    return now;
  }
  [[nodiscard]] Clock::duration late() const override { return late_; }
  [[nodiscard]] Clock::time_point now() const override { return Clock::now(); }
  [[nodiscard]] bool ended() const override { return interruption_.requested(); }

 private:
  std::chrono::nanoseconds period_;
  const Interruption& interruption_;
  Clock::time_point due_ = Clock::now();
  Clock::duration late_{0};
};

const char* text(CheckResult result) {
  switch (result) {
    case CheckResult::kOk:
      return "ok";
    case CheckResult::kFailed:
      return "failed";
    case CheckResult::kNotTested:
      return "not_tested";
  }
  return "not_tested";
}

std::string shown(const DeviceCheck& check, const Palette& palette) {
  if (check.result == CheckResult::kNotTested) return palette.dim("not tested");
  return check.result == CheckResult::kOk ? palette.green("ok") : palette.red("FAILED");
}

std::string value_text(const DeviceCheck& check, double value) {
  if (check.result == CheckResult::kNotTested || check.unit.empty()) return "";
  return check.unit == "s" ? duration_text(value) : decimal_text(value, 5) + " " + check.unit;
}

std::string table_text(const DeviceTestReport& report) {
  const Palette palette = Palette::for_stream(stdout);
  Table table({{"check"}, {"measured", Align::kRight}, {"limit", Align::kRight}, {"result"}, {"details"}});
  for (const DeviceCheck& check : report.checks) {
    table.add({check.title, value_text(check, check.measured), value_text(check, check.limit), shown(check, palette),
               check.details});
  }
  return table.text(palette);
}

Json report_json(const DeviceTestOptions& options, const std::string& type, const DeviceTestReport& report,
                 const std::optional<Interrupted>& interrupted) {
  Json checks = Json::array();
  for (const DeviceCheck& check : report.checks) {
    const bool tested = check.result != CheckResult::kNotTested && !check.unit.empty();
    checks.push_back({{"check", check.name},
                      {"result", text(check.result)},
                      {"measured", tested ? Json(check.measured) : Json(nullptr)},
                      {"limit", tested ? Json(check.limit) : Json(nullptr)},
                      {"unit", check.unit},
                      {"details", check.details}});
  }
  return {{"arm", options.arm},
          {"device", type},
          {"passed", report.passed()},
          {"checks", checks},
          {"longest_gap", report.longest_gap},
          {"interrupted", to_json(interrupted)}};
}

/// Its index in the cell.
int arm_of(const config::CellFile& file, const std::string& name) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < file.cell.arms.size(); ++i) {
    names.push_back(file.cell.arms[i].arm.name);
    if (names.back() == name) return static_cast<int>(i);
  }
  throw Failure(ExitCode::kBadInput, "ARM = " + config::printable(name) + " must be an arm of " + file.path + ": " +
                                         config::alternatives(names));
}

/// Warns of the motion. Throws Failure when a person does not agree.
void require_consent(const DeviceTestOptions& options, const std::string& type) {
  if (!options.yes && isatty(STDIN_FILENO) == 0) {
    throw Failure(ExitCode::kUsage, "arm " + options.arm + " has a device of type " + type +
                                        " and would move: call 'hecaton device-test' with --yes, or on a terminal");
  }
  std::cerr << "hecaton: arm " << options.arm << " moves now: each joint by " << config::number_text(options.distance)
            << " rad (m), alone and all together. No planner avoids contacts. Its cell must be down, its surroundings "
               "free, and a person at the emergency stop.\n";
  if (options.yes) return;
  std::cerr << "Go on? [y/N] " << std::flush;
  std::string answer;
  std::getline(std::cin, answer);
  if (answer != "y" && answer != "yes") throw Failure(ExitCode::kNegative, "nothing was tested, nothing has moved");
}

ExitCode run_device_test(const Settings& settings, const DeviceTestOptions& options) {
  const config::CellFile file = config::load_cell_file(options.cell);
  const int arm = arm_of(file, options.arm);
  const config::DeviceOptions& chosen = file.devices[arm];
  if (starts_observed(chosen)) {
    throw Failure(ExitCode::kBadInput,
                  chosen.where + ".type = observed: others move arm " + options.arm +
                      ", and a device-test would; name the type of its device in a copy of the file");
  }
  require_known_devices(file);
  ServiceOptions as_driver;
  as_driver.cell = options.cell;
  as_driver.arm = options.arm;
  as_driver.domain = settings.domain;
  const auto device = make_device(file, arm, {}, device::device_types(), {},
                                  [&file, &as_driver] { return join_as_device(file, as_driver); });
  if (chosen.type != "simulated") require_consent(options, chosen.type);

  const Interruption interruption;
  LivePeriods periods(nanoseconds(file.cell.timing.driver_period), interruption);
  if (file.real_time) static_cast<void>(raise_priority(ThreadPriority::kSafety));
  DeviceTestSetup setup{control_setup(file, arm), file.cell.timing.control_period, options.distance, options.duration};
  setup.progress = [](std::string_view what) {
    if (is_terminal(stderr)) std::cerr << "hecaton: " << what << "\n";
  };
  const DeviceTestReport report = test_device(setup, *device, periods);

  const auto interrupted = interruption.after(report.tested(), report.checks.size(), "checks");
  print(settings, report_json(options, chosen.type, report, interrupted), table_text(report));
  if (report.longest_gap > std::chrono::duration<double>(setup.control.valid_for).count()) {
    complain("this machine was busy: " + duration_text(report.longest_gap) +
             " passed between two periods of the driver, which may fail a check; repeat it on an idle machine");
  }
  if (interrupted) {
    complain(interrupted->text());
    return interrupted->exit_code();
  }
  return report.passed() ? ExitCode::kDone : ExitCode::kNegative;
}

}  // namespace

void add_device_test(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "device-test",
      "Moves an arm a little, without a cell, and tests whether its device keeps the contract of devices");
  auto options = std::make_shared<DeviceTestOptions>();
  command->add_option("CELL", options->cell, "cell file (YAML)")->required();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  add_number(
      *command, "--distance", [options](double distance) { options->distance = distance; },
      "by which each joint moves, in rad or m (0.05)", config::Bounds{0.005, 0.5});
  add_duration(*command, "--duration", options->duration, "of the motion of each joint, at least (2s)", 0.5, 60.0);
  command->add_flag("--yes", options->yes, "the arm may move: do not ask");
  command->footer(
      "The arm moves, and no planner avoids contacts: stop its cell, free its surroundings, and keep a hand on the "
      "emergency stop. Ctrl-C stops the arm. Exit code 0: all checks passed; 1: one failed or could not be made. No "
      "check is a safety function.");
  command->callback([&session, options] {
    session.action = [&session, options] { return run_device_test(session.settings, *options); };
  });
}

}  // namespace hecaton::services::cli
