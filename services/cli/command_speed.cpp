/// hecaton speed: shows and sets the speed override of the cell or of some arms.

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <memory>
#include <string_view>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/cli/status_output.hpp"
#include "services/command_line/program.hpp"
#include "services/config/text.hpp"
#include "services/runtime/orders.hpp"

namespace hecaton::services::cli {
namespace {

struct Words {
  std::string first;  ///< a percentage or the name of an arm; empty: none
  std::vector<std::string> arms;
};

/// Names of arms begin with a letter, except in odd cells: there a percentage must come first.
bool is_number(const std::string& word) {
  return !word.empty() && (std::isdigit(static_cast<unsigned char>(word.front())) != 0 || word.front() == '.' ||
                           word.front() == '+' || word.front() == '-');
}

/// The share in "30%" or "30". Throws Failure (bad input).
double parse_percent(const std::string& word) {
  const std::string_view number(word.data(), word.size() - (word.ends_with('%') ? 1 : 0));
  const double speed = config::parse_number(number).value_or(0.0) / 100.0;
  if (speed >= kSlowestSpeed && speed <= kFullSpeed) return speed;
  throw Failure(ExitCode::kBadInput,
                "speed '" + config::printable(word) + "' must be a percentage from 1% to 100%, such as 30%");
}

/// The arm's own override, null without one.
const msg::ArmSpeed* own_speed(const msg::CellMode& mode, const std::string& arm) {
  const auto found = std::find_if(mode.speeds().begin(), mode.speeds().end(),
                                  [&](const msg::ArmSpeed& own) { return own.arm() == arm; });
  return found == mode.speeds().end() ? nullptr : &*found;
}

void print_speeds(const Settings& settings, const msg::CellStatus& status, const std::vector<std::string>& arms) {
  const msg::CellMode& mode = status.mode();
  Json json{{"cell", status.cell()}, {"speed", mode.speed()}, {"arms", Json::array()}};
  std::string text = "cell " + status.cell() + ": " + speed_text(mode.speed()) + "\n";
  for (const msg::ArmStatus& arm : status.arms()) {
    if (!concerns(arms, arm)) continue;
    const msg::ArmSpeed* own = own_speed(mode, arm.arm());
    json["arms"].push_back({{"name", arm.arm()},
                            {"speed", arm.speed()},
                            {"own_speed", own == nullptr ? Json(nullptr) : Json(own->speed())}});
    text += arm.arm() + ": " + speed_text(arm.speed());
    if (own != nullptr) text += " (its own " + speed_text(own->speed()) + ")";
    text += "\n";
  }
  print(settings, json, text);
}

ExitCode run_speed(const Settings& settings, const Words& words) {
  const bool sets = is_number(words.first);
  std::vector<std::string> arms = words.arms;
  if (!sets && !words.first.empty()) arms.insert(arms.begin(), words.first);
  msg::SupervisorRequest request;
  request.kind(msg::RequestKind::REQUEST_SPEED);
  request.arms(arms);
  if (sets) request.speed(parse_percent(words.first));
  const Connection cell = connect(settings);
  const msg::CellStatus status = cell->status(answer_limit(settings));
  require_arms(status, arms);
  if (!sets) {
    print_speeds(settings, status, arms);
    return ExitCode::kDone;
  }
  const msg::SupervisorReply reply = cell->order(std::move(request), answer_limit(settings));
  if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
  if (!is_none(reply.cause())) std::fprintf(stderr, "done, but %s\n", reply.cause().text().c_str());
  print_speeds(settings, reply.status(), arms);
  return ExitCode::kDone;
}

}  // namespace

void add_speed(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "speed", "Sets the speed of the cell or of some arms as a share of their velocity limits; alone it shows it");
  auto words = std::make_shared<Words>();
  command->add_option("PERCENT", words->first, "1% to 100%; goals under way continue (shows the present speeds)");
  command->add_option("ARM", words->arms,
                      "names of arms (the whole cell); the lower of the cell's speed and the arm's own is in force");
  command->footer("No safety function: only the safety functions of the robots limit their speed for people.");
  command->callback([&session, words] {
    session.action = on_cell([&session, words] { return run_speed(session.settings, *words); });
  });
}

}  // namespace hecaton::services::cli
