#include "planner/model/xacro.hpp"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "planner/model/xml_checks.hpp"

namespace hecaton::planner {
namespace {

namespace fs = std::filesystem;

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

/// The package that xacro could not find, from its reason; empty: the reason is another one.
std::string missing_package(const std::string& reason) {
  constexpr std::string_view kBefore = "package '";
  constexpr std::string_view kAfter = "' not found";
  const std::size_t end = reason.find(kAfter);
  const std::size_t at = end == std::string::npos ? end : reason.rfind(kBefore, end);
  return at == std::string::npos ? "" : reason.substr(at + kBefore.size(), end - at - kBefore.size());
}

/// A name that ROS allows for a package. Others, such as "../x", would leave the folder of an index.
bool is_package_name(std::string_view name) {
  return !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.');
  });
}

/// A folder with an index of packages, as ROS 2 has it below each prefix. Removed at the end.
class PackageIndex {
 public:
  /// Leaves out names that no package has. Throws std::system_error.
  explicit PackageIndex(const std::map<std::string, std::string>& packages) {
    // mkdtemp() makes a folder of its own, which only this user can open.
    std::string name = (fs::temp_directory_path() / "hecaton-packages-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::system_error(errno, std::generic_category(), name);
    prefix_ = name;
    try {
      fill(packages);
    } catch (...) {
      remove();
      throw;
    }
  }
  ~PackageIndex() { remove(); }
  PackageIndex(const PackageIndex&) = delete;
  PackageIndex& operator=(const PackageIndex&) = delete;
  PackageIndex(PackageIndex&&) = delete;
  PackageIndex& operator=(PackageIndex&&) = delete;

  /// This process's environment, in which both generations of ROS find the packages of the index before others.
  [[nodiscard]] std::vector<std::string> environment() const {
    std::string prefixes = "AMENT_PREFIX_PATH=" + prefix_.string();
    std::string folders = "ROS_PACKAGE_PATH=" + (prefix_ / "share").string();
    std::vector<std::string> all;
    for (char** entry = environ; *entry != nullptr; ++entry) {
      const std::string_view text = *entry;
      const std::size_t value = text.find('=') + 1;
      std::string* const list = text.starts_with("AMENT_PREFIX_PATH=")  ? &prefixes
                                : text.starts_with("ROS_PACKAGE_PATH=") ? &folders
                                                                        : nullptr;
      if (list == nullptr) {
        all.emplace_back(text);
      } else if (value < text.size()) {
        *list += ":" + std::string(text.substr(value));
      }
    }
    all.push_back(std::move(prefixes));
    all.push_back(std::move(folders));
    return all;
  }

 private:
  void fill(const std::map<std::string, std::string>& packages) const {
    const fs::path markers = prefix_ / "share" / "ament_index" / "resource_index" / "packages";
    fs::create_directories(markers);
    for (const auto& [package, folder] : packages) {
      if (!is_package_name(package)) continue;
      std::ofstream(markers / package).flush();
      fs::create_directory_symlink(fs::absolute(folder), prefix_ / "share" / package);
    }
  }
  void remove() const {
    std::error_code ignored;
    fs::remove_all(prefix_, ignored);
  }

  fs::path prefix_;
};

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> all;
  for (std::string& word : words) all.push_back(word.data());
  all.push_back(nullptr);
  return all;
}

/// Kills the child at the time limit, so that it ends soon in any case. False: it was killed.
bool ends_in_time(pid_t child, std::chrono::seconds time_limit) {
  const auto end = std::chrono::steady_clock::now() + time_limit;
  const int fd = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  if (fd < 0) return true;  // a kernel before Linux 5.3: no limit
  int ready = 0;
  do {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
    pollfd ended{fd, POLLIN, 0};
    ready = poll(&ended, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
  } while (ready < 0 && errno == EINTR);
  close(fd);
  if (ready != 0) return true;
  kill(child, SIGKILL);
  return false;
}

constexpr int kTookTooLong = -2;

/// Starts the program and waits for its end. Empty when the PATH does not have it, else its exit status, or
/// kTookTooLong.
std::optional<int> run(std::vector<std::string> words, const PackageIndex& index, std::chrono::seconds time_limit,
                       std::FILE* output, std::FILE* errors) {
  std::vector<std::string> environment = index.environment();
  const std::vector<char*> arguments = pointers(words);
  const std::vector<char*> variables = pointers(environment);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(output), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(errors), STDERR_FILENO);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments.front(), &actions, nullptr, arguments.data(), variables.data());
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) return std::nullopt;
  const bool in_time = ends_in_time(child, time_limit);
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  if (!in_time) return kTookTooLong;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// What the user can do about the program's failure.
std::string remedy(const std::string& missing_package, const XacroOptions& options) {
  if (missing_package.empty()) {
    if (!options.arguments_option.empty()) return options.arguments_option + " gives it arguments";
    return "if it needs arguments, expand it first (xacro in.xacro NAME:=VALUE > out.urdf)";
  }
  std::string option = options.packages_option;
  if (const std::size_t name = option.find('@'); name != std::string::npos) option.replace(name, 1, missing_package);
  return "map package '" + missing_package + "' to its folder" + (option.empty() ? "" : " (" + option + ")") +
         ", or keep the file below a folder of that name, or source its ROS 2 workspace";
}

constexpr std::size_t kMostFoundPackages = 64;

}  // namespace

std::optional<std::string> expand_xacro(const std::string& path, SourceFiles& sources,
                                        const XacroOptions& options) try {
  if (sources.place(path) != fs::path(path)) {
    throw ModelError(path +
                     ": the copy of this file is xacro, which is expanded in place only; expand the file first (xacro "
                     "in.xacro > out.urdf)");
  }
  // Absolute, so that no path begins with a dash, as options do.
  std::vector<std::string> words{"xacro", fs::absolute(path).string()};
  for (const auto& [name, value] : options.arguments) words.push_back(name + ":=" + value);
  std::map<std::string, std::string> packages = options.packages;
  // xacro names one missing package at a time.
  while (true) {
    const TemporaryFile output(std::tmpfile());
    const TemporaryFile errors(std::tmpfile());
    if (!output || !errors) throw ModelError(path + ": there is no temporary file for the output of xacro");
    const std::optional<int> status =
        run(words, PackageIndex(packages), options.time_limit, output.get(), errors.get());
    if (!status) return std::nullopt;
    if (*status == kTookTooLong) {
      throw ModelError(path + ": the program xacro did not end within " + std::to_string(options.time_limit.count()) +
                       " s and was killed: look for a macro that includes itself, or expand the file first (xacro "
                       "in.xacro > out.urdf)");
    }
    if (*status == 0) return written(output.get());
    const std::string reason = reason_of_failure(written(errors.get()));
    const std::string missing = missing_package(reason);
    if (!missing.empty() && packages.size() < options.packages.size() + kMostFoundPackages) {
      const auto folder = package_folder(missing, path, options.packages, sources);
      if (folder && packages.try_emplace(missing, folder->string()).second) continue;
    }
    throw ModelError(path + ": xacro cannot expand this file: " + in_quotes(reason, kLongestReason) + "; " +
                     remedy(missing, options));
  }
} catch (const std::system_error& error) {
  throw ModelError(path + ": there is no temporary folder for the packages of xacro: " + error.what());
}

}  // namespace hecaton::planner
