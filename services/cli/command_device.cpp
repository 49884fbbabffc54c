/// hecaton device: a person's order to the device of an arm.

#include <algorithm>
#include <array>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"
#include "services/messages/names.hpp"

namespace hecaton::services::cli {
namespace {

/// Robot controllers answer within a second or two.
constexpr Seconds kAnswerLimit{10.0};
constexpr std::array kOrders{msg::DeviceOrder::DEVICE_POWER_ON, msg::DeviceOrder::DEVICE_POWER_OFF,
                             msg::DeviceOrder::DEVICE_UNLOCK, msg::DeviceOrder::DEVICE_OBSERVE,
                             msg::DeviceOrder::DEVICE_COMMAND};

struct DeviceOptions {
  std::string arm;
  std::string order;
};

ExitCode run_device(const Settings& settings, const DeviceOptions& options) {
  const Connection cell = connect(settings);
  static_cast<void>(require_arm(cell->status(answer_limit(settings)), options.arm));
  const auto* order =
      std::find_if(kOrders.begin(), kOrders.end(), [&](msg::DeviceOrder one) { return text(one) == options.order; });
  const msg::DeviceReply reply = cell->order_device(options.arm, *order, kAnswerLimit);
  if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  print(settings, Json{{"arm", options.arm}, {"order", options.order}, {"done", true}},
        "the device of arm " + options.arm + " has taken the order\n");
  return ExitCode::kDone;
}

}  // namespace

void add_device(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("device", "Switches the device of an arm on or off, unlocks it, or leaves the arm to others");
  auto options = std::make_shared<DeviceOptions>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  std::vector<std::string> names;
  for (const msg::DeviceOrder order : kOrders) names.push_back(text(order));
  add_choice(*command, "ORDER", options->order, names,
             "on: power on and release the brakes; off: power off; unlock: release a protective stop; observe: others "
             "move the arm, and its planner only watches; command: its planner moves it again")
      ->required();
  command->footer(
      "observe ends the goal of the arm: it brakes, then only reports its state, and other arms keep away from it. "
      "Look at the arm first: unlock releases a stop that the robot made by itself. The arm stays held until 'hecaton "
      "resume ARM'. No order is a safety function.");
  command->callback([&session, options] {
    session.action = on_cell([&session, options] { return run_device(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
