/// hecaton io: digital and analog inputs and outputs of the arms' devices.

#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

constexpr config::Bounds kValue{-1e3, 1e3, ""};

struct IoOptions {
  std::string arm;   // empty: all
  std::string name;  // empty: all signals
  std::optional<double> value, until, above, below;
  double timeout = 30.0;  // [s]

  [[nodiscard]] bool waits() const { return until || above || below; }
};

const char* kind_text(msg::SignalKind kind) {
  switch (kind) {
    case msg::SignalKind::SIGNAL_DIGITAL_INPUT:
      return "digital input";
    case msg::SignalKind::SIGNAL_DIGITAL_OUTPUT:
      return "digital output";
    case msg::SignalKind::SIGNAL_ANALOG_INPUT:
      return "analog input";
    case msg::SignalKind::SIGNAL_ANALOG_OUTPUT:
      break;
  }
  return "analog output";
}

std::string value_text(const msg::Signal& signal) {
  if (!signal.known()) return "not known";
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", signal.value());
  return text;
}

Json signal_json(const std::string& arm, const msg::Signal& signal) {
  return {{"arm", arm},
          {"name", signal.name()},
          {"kind", kind_text(signal.kind())},
          {"value", signal.known() ? Json(signal.value()) : Json(nullptr)}};
}

/// The signal of this name; null: the arm has none.
const msg::Signal* find(const msg::ToolState& state, const std::string& name) {
  const auto found = std::find_if(state.signals().begin(), state.signals().end(),
                                  [&](const msg::Signal& signal) { return signal.name() == name; });
  return found == state.signals().end() ? nullptr : &*found;
}

[[noreturn]] void fail_without(const IoOptions& options, const msg::ToolState* state) {
  std::vector<std::string> names;
  if (state != nullptr) {
    for (const msg::Signal& signal : state->signals()) names.push_back(signal.name());
  }
  throw Failure(ExitCode::kBadInput, "arm " + options.arm + " has no signal " + config::printable(options.name) +
                                         (names.empty() ? "; signals are named with the key signals of the cell file"
                                                        : "; it has " + listed(names)));
}

ExitCode list(const Settings& settings, const IoOptions& options, const Connection& cell,
              const msg::CellStatus& status) {
  Json json = Json::array();
  std::string text;
  for (const msg::ArmStatus& arm : status.arms()) {
    if (!options.arm.empty() && arm.arm() != options.arm) continue;
    // The driver of an arm without signals publishes nothing: a short wait tells.
    const auto heard = cell->tool_state(arm.arm(), Seconds(0.5));
    if (!heard) continue;
    for (const msg::Signal& signal : heard->value.signals()) {
      json.push_back(signal_json(arm.arm(), signal));
      text += arm.arm() + " " + signal.name() + ": " + value_text(signal) + " (" + kind_text(signal.kind()) + ")\n";
    }
  }
  print(settings, json, text.empty() ? "no arm has signals\n" : text);
  return ExitCode::kDone;
}

ExitCode run_io(const Settings& settings, const IoOptions& options) {
  const Connection cell = connect(settings);
  const msg::CellStatus status = cell->status(answer_limit(settings));
  if (!options.arm.empty()) static_cast<void>(require_arm(status, options.arm));
  if (options.name.empty()) return list(settings, options, cell, status);
  const auto heard = cell->tool_state(options.arm, answer_limit(settings));
  if (!heard || find(heard->value, options.name) == nullptr) fail_without(options, heard ? &heard->value : nullptr);
  if (options.value) {
    msg::DeviceRequest request;
    request.arm(options.arm);
    request.order(msg::DeviceOrder::DEVICE_SET_SIGNAL);
    request.name(options.name);
    request.value(*options.value);
    const msg::DeviceReply reply = cell->order_device(std::move(request), answer_limit(settings));
    if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  }
  const double infinite = std::numeric_limits<double>::infinity();
  const double lowest = options.until ? *options.until : options.above.value_or(-infinite);
  const double highest = options.until ? *options.until : options.below.value_or(infinite);
  // An output that was set shows within some periods of the device.
  const double limit = options.waits() ? options.timeout : 1.0;
  const auto fits = [&](const msg::ToolState& state) {
    const msg::Signal* signal = find(state, options.name);
    if (signal == nullptr) return false;
    if (options.waits()) return signal->known() && signal->value() >= lowest && signal->value() <= highest;
    return !options.value || (signal->known() && signal->value() == *options.value);
  };
  auto last = cell->tool_state(options.arm, Seconds(limit), fits);
  if (!last && options.waits()) {
    last = cell->tool_state(options.arm, answer_limit(settings));
    const msg::Signal* signal = last ? find(last->value, options.name) : nullptr;
    throw Failure(ExitCode::kNegative, "signal " + options.name + " of arm " + options.arm + " is " +
                                           (signal == nullptr ? "not known" : value_text(*signal)) + " after " +
                                           duration_text(options.timeout));
  }
  if (!last) last = cell->tool_state(options.arm, answer_limit(settings));
  const msg::Signal* signal = last ? find(last->value, options.name) : nullptr;
  if (signal == nullptr) fail_without(options, nullptr);
  print(settings, signal_json(options.arm, *signal), value_text(*signal) + "\n");
  return ExitCode::kDone;
}

}  // namespace

void add_io(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("io", "Lists, reads, sets or awaits signals of the arms' devices");
  auto options = std::make_shared<IoOptions>();
  command->add_option("ARM", options->arm, "name of the arm; left out: the signals of all arms");
  command->add_option("NAME", options->name, "name of the signal in the cell file; left out: all of the arm");
  CLI::Option* value = add_number(
      *command, "VALUE", [options](double number) { options->value = number; },
      "sets the signal: 0 or 1 of a digital one", kValue);
  CLI::Option* until = add_number(
      *command, "--until", [options](double number) { options->until = number; },
      "waits until the signal has this value", kValue);
  CLI::Option* above = add_number(
      *command, "--above", [options](double number) { options->above = number; },
      "waits until the signal is at least this", kValue);
  CLI::Option* below = add_number(
      *command, "--below", [options](double number) { options->below = number; },
      "waits until the signal is at most this", kValue);
  for (CLI::Option* option : {until, above, below}) option->excludes(value);
  until->excludes(above)->excludes(below);
  add_duration(*command, "--timeout", options->timeout, "time limit of a wait (30s)", 0.0, 86400.0);
  command->footer("A simulated arm lets you set its inputs, too: you play its sensors.");
  command->callback([&session, options] {
    if (options->waits() && options->name.empty()) {
      throw CLI::ValidationError("a wait needs the name of an arm and of a signal");
    }
    session.action = on_cell([&session, options] { return run_io(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
