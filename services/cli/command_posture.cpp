/// hecaton posture: where joints outside the chain of an arm are.

#include <memory>
#include <utility>

#include <CLI/CLI.hpp>

#include "services/cli/cell_access.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/document.hpp"
#include "services/command_line/program.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

struct PostureOptions {
  std::string arm;
  std::vector<std::string> places;  // "joint=value"
};

std::vector<std::pair<std::string, double>> parse(const std::vector<std::string>& words) {
  std::vector<std::pair<std::string, double>> places;
  for (const std::string& word : words) {
    const std::size_t sign = word.find('=');
    const auto value = sign == std::string::npos ? std::nullopt : config::parse_number(word.substr(sign + 1));
    if (!value || sign == 0) {
      throw Failure(ExitCode::kBadInput,
                    "'" + config::printable(word) + "' must be JOINT=POSITION in rad or m, such as finger=0.02");
    }
    places.emplace_back(word.substr(0, sign), *value);
  }
  return places;
}

ExitCode run_posture(const Settings& settings, const PostureOptions& options) {
  const auto places = parse(options.places);
  const Connection cell = connect(settings);
  static_cast<void>(require_arm(cell->status(answer_limit(settings)), options.arm));
  Json json{{"arm", options.arm}, {"joints", Json::object()}};
  for (const auto& [joint, position] : places) {
    msg::DeviceRequest request;
    request.arm(options.arm);
    request.order(msg::DeviceOrder::DEVICE_PLACE_JOINT);
    request.name(joint);
    request.value(position);
    const msg::DeviceReply reply = cell->order_device(std::move(request), answer_limit(settings));
    if (!reply.done()) throw Failure(ExitCode::kNegative, reply.cause().text());
    json["joints"][joint] = position;
  }
  print(settings, json, "the planners know where these joints of arm " + options.arm + " are\n");
  return ExitCode::kDone;
}

}  // namespace

void add_posture(CLI::App& app, Session& session) {
  CLI::App* command =
      app.add_subcommand("posture", "Tells the planners where joints outside the chain of an arm are, such as fingers");
  auto options = std::make_shared<PostureOptions>();
  command->add_option("ARM", options->arm, "name of the arm")->required();
  command
      ->add_option("POSITION", options->places, "JOINT=POSITION of a joint that has a range in the cell file [rad | m]")
      ->required()
      ->expected(1, 16);
  command->footer(
      "The order moves nothing: it is for joints that no gripper of Hecaton moves. Until you give it, planners count "
      "the whole range. Repeat the order before the joint moves.");
  command->callback([&session, options] {
    session.action = on_cell([&session, options] { return run_posture(session.settings, *options); });
  });
}

}  // namespace hecaton::services::cli
