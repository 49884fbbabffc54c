/// hecaton obstacle add|move|remove, attach, detach: edits of the world while it runs.

#include <cstdio>
#include <memory>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/obstacle_options.hpp"
#include "services/client/convert.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/quantities.hpp"
#include "services/messages/convert.hpp"

namespace hecaton::services::cli {
namespace {

constexpr const char* kRejections =
    "The rules are those of the cell file: sizes, names, nothing on top of an arm, nothing carried that is far from "
    "the "
    "tool. Exit code 1: the world rejects the edit, and nothing has changed.";

/// The world alone judges and carries out edits: no supervisor is needed.
ExitCode edit(const Settings& settings, const msg::WorldEditRequest& request, const std::string& done) {
  const msg::WorldEditReply reply = connect(settings)->edit(request, answer_limit(settings));
  const Cause cause = client::to_public(reply.cause());
  if (!reply.done()) throw Rejected(cause);
  if (cause) std::fprintf(stderr, "done, but %s\n", cause.text.c_str());
  print(settings, {{"done", true}, {"name", request.name()}, {"edition", reply.edition()}}, done + "\n");
  return ExitCode::kDone;
}

msg::WorldEditRequest request_for(msg::EditKind kind, const std::string& name) {
  msg::WorldEditRequest request;
  request.kind(kind);
  request.name(name);
  return request;
}

void add_obstacle_add(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("add", "Adds an obstacle");
  auto options = std::make_shared<ObstacleOptions>();
  add_obstacle_options(*command, *options);
  command->callback([&session, options] {
    const world::Obstacle obstacle = make_obstacle(*options);
    session.action = on_cell([&session, obstacle] {
      msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_ADD, obstacle.name);
      request.obstacle(messages::to_message(obstacle));
      return edit(session.settings, request, "added " + obstacle.name);
    });
  });
}

void add_obstacle_move(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("move", "Puts an obstacle elsewhere; ends a scripted motion");
  auto name = std::make_shared<std::string>();
  auto pose = std::make_shared<std::vector<double>>();
  command->add_option("NAME", *name, "the obstacle")->required();
  add_pose(*command, "--pose", *pose, kPoseHelp)->required();
  command->callback([&session, name, pose] {
    session.action = on_cell([&session, name, pose] {
      msg::WorldEditRequest request = request_for(msg::EditKind::EDIT_MOVE, *name);
      request.X_WO(messages::to_message(pose_of(*pose)));
      return edit(session.settings, request, "moved " + *name);
    });
  });
}

void add_obstacle_remove(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("remove", "Takes an obstacle out of the cell");
  auto name = std::make_shared<std::string>();
  command->add_option("NAME", *name, "the obstacle")->required();
  command->callback([&session, name] {
    session.action = on_cell([&session, name] {
      return edit(session.settings, request_for(msg::EditKind::EDIT_REMOVE, *name), "removed " + *name);
    });
  });
}

void add_carry(CLI::App& app, Session& session, const char* command_name, const char* description, msg::EditKind kind) {
  CLI::App* command = app.add_subcommand(command_name, description);
  auto arm = std::make_shared<std::string>();
  auto object = std::make_shared<std::string>();
  command->add_option("ARM", *arm, "name of the arm")->required();
  command->add_option("OBJECT", *object, "name of the obstacle")->required();
  command->footer(kRejections);
  command->callback([&session, arm, object, kind] {
    session.action = on_cell([&session, arm, object, kind] {
      msg::WorldEditRequest request = request_for(kind, *object);
      request.arm(*arm);
      const bool attach = kind == msg::EditKind::EDIT_ATTACH;
      return edit(session.settings, request, *arm + (attach ? " carries " : " has let go of ") + *object);
    });
  });
}

}  // namespace

void add_obstacle(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand("obstacle", "Adds, moves or removes obstacles while the cell runs");
  command->require_subcommand(1);
  add_obstacle_add(*command, session);
  add_obstacle_move(*command, session);
  add_obstacle_remove(*command, session);
  command->footer(kRejections);
}

void add_carry_commands(CLI::App& app, Session& session) {
  add_carry(app, session, "attach", "Fixes an object to an arm's tool where it is now: it becomes part of the arm",
            msg::EditKind::EDIT_ATTACH);
  add_carry(app, session, "detach", "Lets go of a carried object: dynamic ones fall, others stay where they are",
            msg::EditKind::EDIT_DETACH);
}

}  // namespace hecaton::services::cli
