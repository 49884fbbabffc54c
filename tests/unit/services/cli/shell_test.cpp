/// The man page and the completion, as a shell sees them.

#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>
#include <unistd.h>

#include "services/command_line/command_line_shape.hpp"
#include "tests/unit/services/cli/run_line.hpp"

namespace hecaton::services::cli {
namespace {

std::string output_of(const std::string& command) {
  std::string out;
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::array<char, 4096> buffer{};
  while (pipe && std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) out += buffer.data();
  return out;
}

/// What bash would offer for the last of `words`.
std::vector<std::string> completions(const std::string& words) {
  const std::string script = testing::TempDir() + "hecaton_completion_" + std::to_string(getpid()) + ".bash";
  std::ofstream(script) << run_line({"completion", "bash"}).out << "hecaton() { :; }\nCOMP_WORDS=(" << words
                        << ")\nCOMP_CWORD=$((${#COMP_WORDS[@]} - 1))\n_hecaton\nprintf '%s\\n' \"${COMPREPLY[@]}\"\n";
  std::istringstream lines(output_of("bash --norc " + script + " 2>&1"));
  std::vector<std::string> found;
  for (std::string line; std::getline(lines, line);) found.push_back(line);
  std::remove(script.c_str());
  return found;
}

using Words = std::vector<std::string>;

TEST(Completion, OffersCommands) {
  EXPECT_EQ(completions("hecaton obs"), (Words{"obstacles", "obstacle"}));
  EXPECT_EQ(completions("hecaton obstacle m"), Words{"move"});
}

TEST(Completion, OffersOptionsOfTheCommandAndGlobalOnes) {
  EXPECT_EQ(completions("hecaton goal north --jo"), Words{"--joints"});
  EXPECT_EQ(completions("hecaton goal north --ou"), Words{"--output"});
  EXPECT_EQ(completions("hecaton status --wa"), Words{"--watch"});
}

TEST(Completion, OffersChoices) {
  EXPECT_EQ(completions("hecaton status -o j"), Words{"json"});
  EXPECT_EQ(completions("hecaton wait north --for bl"), Words{"blocked"});
  EXPECT_EQ(completions("hecaton simulate x --method bo"), Words{"boundary_following"});
  EXPECT_EQ(completions("hecaton plan x --method rrt_"), Words{"rrt_connect"});
}

TEST(ManPage, TellsOfEveryCommandAndOption) {
  Session session;
  const auto app = make_application(hecaton_program(), session);
  const std::string page = man_page(*app, "moves arms", "1.2.3");
  EXPECT_EQ(page.rfind(".TH HECATON 1", 0), 0U);
  for (const CLI::App* command : subcommands_of(*app)) {
    EXPECT_NE(page.find(".SS \\fBhecaton " + command->get_name()), std::string::npos) << command->get_name();
    for (const CLI::Option* option : options_of(*command)) {
      for (const std::string& name : option->get_lnames()) {
        std::string escaped;
        for (const char c : "--" + name) escaped += c == '-' ? std::string("\\-") : std::string(1, c);
        EXPECT_NE(page.find(escaped), std::string::npos) << name;
      }
    }
  }
}

TEST(ManPage, IsPrintedByItsCommand) {
  EXPECT_EQ(run_line({"man"}).out.rfind(".TH HECATON 1", 0), 0U);
}

}  // namespace
}  // namespace hecaton::services::cli
