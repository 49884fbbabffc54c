#include "services/runtime/run_folder.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "planner/model/fnv1a.hpp"
#include "services/runtime/version.hpp"

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSharedMemory = "/dev/shm";
constexpr const char* kPrefix = "hecaton-";
/// No name of a cell or host contains it, nor any other folder of Hecaton.
constexpr char kBeforeHost = '@';
constexpr const char* kOrigin = "origin";

// Between fork and exec a child of a killed agent holds the lock, too. It ends shortly after the agent.
constexpr int kAttempts = 100;
constexpr int kBetweenAttempts = 10;  // [ms]

fs::path parent_of_runs() {
  const char* chosen = std::getenv("TMPDIR");
  if (chosen != nullptr && *chosen != '\0') return fs::absolute(chosen);
  return ::access(kSharedMemory, W_OK | X_OK) == 0 ? kSharedMemory : "/tmp";
}

[[noreturn]] void fail(const fs::path& path, const std::string& why) {
  throw std::runtime_error("the folder of the run, " + path.string() + ", cannot be used: " + why +
                           "; set TMPDIR to another folder");
}

/// Opens the folder and locks it. Returns its descriptor, or −1 and errno: EWOULDBLOCK when another process holds the
/// lock, ESTALE when that process has removed the folder meanwhile.
int open_locked(const fs::path& path) {
  const int folder = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (folder < 0) return -1;
  struct stat own {};
  struct stat named {};
  int error = 0;
  if (::flock(folder, LOCK_EX | LOCK_NB) != 0 || ::fstat(folder, &own) != 0) {
    error = errno;
  } else if (::stat(path.c_str(), &named) != 0 || named.st_ino != own.st_ino) {
    error = ESTALE;
  }
  if (error == 0) return folder;
  ::close(folder);
  errno = error;
  return -1;
}

bool is_ours(const fs::path& path) {
  struct stat about {};
  return ::lstat(path.c_str(), &about) == 0 && S_ISDIR(about.st_mode) && about.st_uid == ::geteuid();
}

/// What an agent has made has an origin, or nothing at all. All else stays.
bool is_of_a_run(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(fs::symlink_status(path / kOrigin, error)) || fs::is_empty(path, error);
}

/// Removes all but the origin, whose text no run has from now on: an interruption leaves no checkpoints that count.
void discard(const fs::path& path) {
  std::ofstream(path / kOrigin, std::ios::binary | std::ios::trunc).flush();
  for (const auto& entry : fs::directory_iterator(path)) {
    if (entry.path().filename() != kOrigin) fs::remove_all(entry.path());
  }
}

/// For the holder of the lock. A dying service may still create a file: then the folder stays, for the next agent.
void remove_locked(const fs::path& path) {
  if (!is_of_a_run(path)) return;
  std::error_code error;
  try {
    discard(path);
  } catch (const fs::filesystem_error&) {
    return;
  }
  fs::remove(path / kOrigin, error);
  if (!fs::remove(path, error) && error) std::ofstream(path / kOrigin, std::ios::binary).flush();
}

/// Does nothing when a process holds the lock.
void remove_unlocked(const fs::path& path) {
  const int folder = open_locked(path);
  if (folder < 0) return;
  remove_locked(path);
  ::close(folder);
}

std::string bytes_of(std::ifstream& file) {
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return bytes_of(file);
}

std::string read_source(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + " cannot be read any more");
  return bytes_of(file);
}

}  // namespace

fs::path run_path(const RunName& run) {
  return parent_of_runs() / (kPrefix + std::to_string(run.domain) + "-" + run.cell + kBeforeHost + run.host);
}

std::string run_origin(const planner::SourceFiles& sources) {
  std::string boot;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), boot);
  std::string text = "version " + std::string(kVersion) + "\nboot " + boot + '\n';
  for (const std::string& path : sources.read()) {
    const std::string bytes = read_source(sources.place(path));
    text += "file " + std::to_string(bytes.size()) + ' ' + std::to_string(planner::fnv1a(bytes)) + ' ' + path + '\n';
  }
  return text;
}

RunFolder::RunFolder(const RunName& run, const std::string& origin, bool clean) : path_(run_path(run)) {
  take(run);
  try {
    begin(origin, clean);
  } catch (...) {
    give_back();
    throw;
  }
  remove_abandoned();
}

RunFolder::RunFolder(RunFolder&& other) noexcept
    : path_(std::move(other.path_)),
      folder_(std::exchange(other.folder_, -1)),
      resumed_(other.resumed_),
      discarded_(other.discarded_),
      kept_(other.kept_) {}

RunFolder::~RunFolder() {
  if (folder_ >= 0) give_back();
}

void RunFolder::give_back() {
  if (!kept_) remove_locked(path_);
  ::close(folder_);
}

void RunFolder::take(const RunName& run) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (::mkdir(path_.c_str(), 0700) != 0 && errno != EEXIST) fail(path_, std::strerror(errno));
    // In a folder that all users may write to, another user could plant checkpoints.
    if (!is_ours(path_)) fail(path_, "it belongs to another user");
    folder_ = open_locked(path_);
    if (folder_ >= 0) return;
    if (errno != EWOULDBLOCK && errno != ESTALE && errno != ENOENT) fail(path_, std::strerror(errno));
    ::poll(nullptr, 0, kBetweenAttempts);
  }
  throw std::runtime_error("host " + run.host + " of cell " + run.cell + " in DDS domain " +
                           std::to_string(run.domain) + " already has an agent on this machine, which holds " +
                           path_.string());
}

void RunFolder::begin(const std::string& origin, bool clean) {
  const fs::path file = path_ / kOrigin;
  if (!is_of_a_run(path_)) {
    fail(path_, "it holds files that no run has made");
  }
  const bool was_used = !fs::is_empty(path_);
  resumed_ = !clean && read(file) == origin;
  kept_ = resumed_;
  if (!resumed_) {
    discarded_ = was_used && !clean;
    discard(path_);
    std::ofstream written(file, std::ios::binary);
    written << origin;
    if (!written.flush()) fail(path_, std::strerror(errno));
  }
  touch();
}

void RunFolder::touch() const {
  static_cast<void>(::futimens(folder_, nullptr));
}

void RunFolder::remove_abandoned() const {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(path_.parent_path(), ignored)) {
    const std::string name = entry.path().filename();
    if (!name.starts_with(kPrefix) || name.find(kBeforeHost) == std::string::npos) continue;
    if (!is_ours(entry.path())) continue;
    struct stat about {};
    if (::stat(entry.path().c_str(), &about) != 0) continue;
    if (std::time(nullptr) - about.st_mtim.tv_sec < std::chrono::seconds(kAbandoned).count()) continue;
    remove_unlocked(entry.path());
  }
}

void remove_run(const RunName& run) {
  remove_unlocked(run_path(run));
}

}  // namespace hecaton::services
