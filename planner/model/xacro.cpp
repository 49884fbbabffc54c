#include "planner/model/xacro.hpp"

#include <cerrno>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string_view>
#include <vector>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "planner/model/source_file.hpp"
#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using TemporaryFile = std::unique_ptr<std::FILE, CloseFile>;

std::string written(std::FILE* file) {
  std::rewind(file);
  std::string text;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;) text.append(buffer, n);
  return text;
}

/// The line of xacro's error, which lines about its place in the files follow. Without it, the last line.
std::string reason_of_failure(const std::string& text) {
  constexpr std::string_view kError = "error: ";
  std::istringstream lines(text);
  std::string last;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(kError)) return line.substr(kError.size());
    if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
  }
  return last;
}

/// Starts the program and waits for its end. Empty when the PATH does not have it, else its exit status.
std::optional<int> run(std::vector<std::string> words, std::FILE* output, std::FILE* errors) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(errors), STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return std::nullopt;
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

std::optional<std::string> expand_xacro(const std::string& path, const std::string& place,
                                        const XacroArguments& arguments) {
  const TemporaryFile output(std::tmpfile());
  const TemporaryFile errors(std::tmpfile());
  if (!output || !errors) throw ModelError(path + ": there is no temporary file for the output of xacro");
  std::vector<std::string> words{"xacro", place};
  for (const auto& [name, value] : arguments) words.push_back(name + ":=" + value);
  const std::optional<int> status = run(std::move(words), output.get(), errors.get());
  if (!status) return std::nullopt;
  if (*status != 0) {
    throw ModelError(path + ": xacro cannot expand this file: " +
                     in_quotes(reason_of_failure(written(errors.get())), kLongestReason));
  }
  return written(output.get());
}

}  // namespace hecaton::planner
