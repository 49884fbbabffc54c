/// hecaton tool: opens and closes the gripper of an arm.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/program.hpp"

namespace hecaton::services::cli {
namespace {

struct ToolOptions {
  std::string arm;
  std::string order;
  double width = -1.0;  // [m]; negative: as far as it goes
  double force = -1.0;  // [N]; negative: the gripper's own
};

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", metres * 1e3);
  return text;
}

/// The state in a sentence.
std::string sentence(const msg::ToolState& state) {
  std::string text = "the gripper of arm " + state.arm();
  text += state.moving() ? " moves" : " stands";
  if (state.width() >= 0.0) text += ", " + millimetres(state.width()) + " wide";
  text += state.holding().empty() ? ", and holds nothing" : ", and holds " + state.holding();
  return text + "\n";
}

ExitCode run_tool(const Settings& settings, const ToolOptions& options) {
  const Connection cell = connect(settings);
  static_cast<void>(require_arm(cell->status(answer_limit(settings)), options.arm));
  if (!options.order.empty()) {
    msg::DeviceRequest request;
    request.arm(options.arm);
    request.order(options.order == "open" ? msg::DeviceOrder::DEVICE_OPEN_TOOL : msg::DeviceOrder::DEVICE_CLOSE_TOOL);
    request.width(options.width);
    request.force(options.force);
    const msg::DeviceReply reply = cell->order_device(std::move(request), kGripperLimit);
    if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  }
  const auto heard = cell->tool_state(options.arm, answer_limit(settings), [&](const msg::ToolState& state) {
    return options.order.empty() || !state.moving();
  });
  if (!heard || !heard->value.has_gripper()) {
    throw Failure(ExitCode::kNegative,
                  "arm " + options.arm + " has no gripper; give it one with the key gripper of the cell file");
  }
  print(settings, to_json(heard->value), sentence(heard->value));
  return ExitCode::kDone;
}

}  // namespace

void add_tool(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("tool", "Opens or closes the gripper of an arm, or shows its state");
  auto options = std::make_shared<ToolOptions>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  add_choice(*command, "ORDER", options->order, {"open", "close"},
             "open: release what it holds; close: hold what is between its fingers; left out: show the state");
  const config::Bounds metres{0.0, 10.0, "m"};
  const config::Bounds newtons{0.0, 1e5, "N"};
  add_number(
      *command, "--width", [options](double width) { options->width = width; },
      "of the opening [m] (as far as the gripper goes)", metres);
  add_number(
      *command, "--force", [options](double force) { options->force = force; }, "of the grip [N] (the gripper's own)",
      newtons);
  command->footer(
      "The arm must stand. What the gripper holds becomes part of the arm: it is no obstacle to this arm any more, and "
      "other arms keep away from it. The command returns when the gripper has arrived. No order is a safety function.");
  command->callback([&session, options] {
    session.action = on_cell([&session, options] { return run_tool(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
