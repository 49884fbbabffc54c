/// hecaton init: writes a cell file for robots and their bases.

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "services/cli/cell_draft.hpp"
#include "services/cli/commands.hpp"
#include "services/command_line/options.hpp"
#include "services/command_line/terminal.hpp"
#include "services/config/robot_catalogue.hpp"
#include "services/config/text.hpp"

namespace hecaton::services::cli {
namespace {

struct InitOptions {
  std::string path = "cell.yaml";
  std::vector<std::string> arms;
  RobotFileOptions files;
};

/// One line of the answer; the default for an empty line. Throws Failure at the end of the input.
std::string ask(std::istream& in, std::ostream& out, const std::string& question, const std::string& otherwise) {
  out << question << (otherwise.empty() ? ": " : " [" + otherwise + "]: ") << std::flush;
  std::string answer;
  if (!std::getline(in, answer)) throw Failure(ExitCode::kUsage, "the input ended before the last answer");
  return answer.empty() ? otherwise : answer;
}

std::string robots_on_one_line() {
  const std::vector<std::string> names = config::robot_names();
  const std::vector<std::string_view> words(names.begin(), names.end());
  return config::listed(words);
}

/// Throws Failure (bad input) unless the answer is a robot's name, or a file; a tool link may follow a colon.
void require_robot(const std::string& answer) {
  const std::string robot = split_tool_link(answer).first;
  if (config::is_robot_name(robot) || std::filesystem::exists(robot)) return;
  throw Failure(ExitCode::kBadInput, "'" + config::printable_path(robot) + "' is neither a robot's name nor a file; " +
                                         config::robot_suggestion(robot));
}

/// The first arm stands at the origin, the next ones beside it; another arm of a robot where that robot stands.
std::string proposed_base(const std::string& robot, const std::vector<std::string>& arms) {
  const DraftArm next = parse_draft_arm("next=" + robot);
  for (const std::string& word : arms) {
    const DraftArm arm = parse_draft_arm(word);
    const bool two_arms = !arm.tool_link.empty() && !next.tool_link.empty() && arm.tool_link != next.tool_link;
    if (arm.robot == next.robot && two_arms) return word.substr(word.rfind('@') + 1);
  }
  return arms.empty() ? "0 0 0" : std::to_string(arms.size()) + " 0 0";
}

void write_new(const std::string& path, const std::string& text) {
  std::FILE* file = std::fopen(path.c_str(), "wx");
  if (file == nullptr && errno == EEXIST) {
    throw Failure(ExitCode::kBadInput, "'" + path + "' exists already: name another file with -o, or remove it");
  }
  if (file == nullptr) throw Failure(ExitCode::kBadInput, "'" + path + "' cannot be written: " + std::strerror(errno));
  const bool written = std::fputs(text.c_str(), file) >= 0;
  if (std::fclose(file) != 0 || !written) {
    throw Failure(ExitCode::kBadInput, "'" + path + "' cannot be written: " + std::strerror(errno));
  }
}

void refuse_existing(const std::string& path) {
  if (access(path.c_str(), F_OK) != 0) return;
  throw Failure(ExitCode::kBadInput, "'" + path + "' exists already: name another file with -o, or remove it");
}

ExitCode run_init(const InitOptions& options) {
  refuse_existing(options.path);  // before the work; write_new() decides
  std::vector<DraftArm> arms;
  for (const std::string& word : options.arms) {
    arms.push_back(parse_draft_arm(word));
    arms.back().files = options.files;
  }
  const CellDraft draft = draft_cell(arms, options.path);
  write_new(options.path, draft.text);
  for (const config::Finding& finding : draft.findings) {
    if (finding.severity == config::Severity::kNote) continue;
    std::fprintf(stderr, "hecaton: %s\n", config::sentence_text(finding.sentence).c_str());
  }
  std::printf("%s: %zu arm%s\n%s\nnext: hecaton check %s\n", config::valid_utf8(options.path).c_str(), arms.size(),
              arms.size() == 1 ? "" : "s", goals_text(draft.file.cell.tasks).c_str(), shell_word(options.path).c_str());
  return ExitCode::kDone;
}

}  // namespace

std::vector<std::string> ask_for_arms(std::istream& in, std::ostream& out, const RobotFileOptions& files) {
  out << "Robots by name: " << robots_on_one_line()
      << ".\nA path of a URDF works as well. An empty arm name ends the list.\n";
  std::vector<std::string> arms;
  std::vector<std::string> names;
  std::string robot = "ur5e";
  for (;;) {
    const auto asked = [&](const std::string& question, const std::string& otherwise, const auto& check) {
      for (;;) {
        const std::string answer = ask(in, out, question, otherwise);
        try {
          check(answer);
          return answer;
        } catch (const Failure& failure) {
          out << failure.what() << "\n";
        } catch (const planner::ModelError& error) {
          out << error.what() << "\n";
        }
      }
    };
    const std::string number = std::to_string(arms.size() + 1);
    const std::string name = ask(in, out, "name of arm " + number, "");
    if (name.empty() && !arms.empty()) return arms;
    if (!config::is_name(name)) {
      out << "'" << config::printable(name) << "' must be " << config::kNameRule << ", such as left\n";
      continue;
    }
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      out << "another arm has the name " << name << ": give this one another\n";
      continue;
    }
    robot = asked("robot of " + name, robot, [&](const std::string& answer) {
      require_robot(answer);
      DraftArm arm = parse_draft_arm(name + "=" + answer);
      arm.files = files;
      require_usable(arm);
    });
    const std::string base = asked(
        "base of " + name + ", x y z in m, or x y z roll pitch yaw in m and rad", proposed_base(robot, arms),
        [&](const std::string& answer) { static_cast<void>(parse_draft_arm(name + "=" + robot + "@" + answer)); });
    arms.push_back(name + "=" + robot + "@" + base);
    names.push_back(name);
  }
}

void add_init(CLI::App& app, Session& session) {
  CLI::App* command = app.add_subcommand(
      "init", "Writes a commented cell file for robots and their bases; without arms it asks, on a terminal");
  auto options = std::make_shared<InitOptions>();
  command->add_option("-o,--file", options->path, "the cell file to write; an existing file stays (cell.yaml)")
      ->type_name("FILE");
  command
      ->add_option("ARMS", options->arms,
                   "each NAME=ROBOT@\"x y z roll pitch yaw\": ROBOT is a name of `hecaton robots` or a URDF; "
                   "ROBOT:LINK chooses the tool's link; the rotation is optional")
      ->take_all();
  add_robot_file_options(*command, options->files, "of the arms with a URDF: ");
  command->footer("Try it: hecaton init -o cell.yaml left=ur5e@\"-0.5 0 0\" right=panda@\"0.5 0 0 0 0 3.14\"");
  command->callback([&session, options] {
    session.action = [options] {
      if (options->arms.empty()) {
        if (isatty(STDIN_FILENO) == 0) {
          throw Failure(ExitCode::kUsage,
                        "an arm is missing: NAME=ROBOT@\"x y z roll pitch yaw\"; see 'hecaton init --help'");
        }
        options->arms = ask_for_arms(std::cin, std::cout, options->files);
      }
      return run_init(*options);
    };
  });
}

}  // namespace hecaton::services::cli
