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

namespace hecaton::services {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSharedMemory = "/dev/shm";
constexpr const char* kPrefix = "hecaton-";
/// In no name of a cell or host, nor in any other folder of ours.
constexpr char kBeforeHost = '@';
constexpr const char* kOrigin = "origin";

// A killed agent's child has the lock, too, between its fork and its end, which comes with the agent's.
constexpr int kLooks = 100;
constexpr int kBetweenLooks = 10;  // [ms]

fs::path parent_of_runs() {
  const char* chosen = std::getenv("TMPDIR");
  if (chosen != nullptr && *chosen != '\0') return fs::absolute(chosen);
  return ::access(kSharedMemory, W_OK | X_OK) == 0 ? kSharedMemory : "/tmp";
}

fs::path folder_of(const RunName& run) {
  return parent_of_runs() / (kPrefix + std::to_string(run.domain) + "-" + run.cell + kBeforeHost + run.host);
}

[[noreturn]] void cannot_be_had(const fs::path& path, const std::string& why) {
  throw std::runtime_error("the folder of the run, " + path.string() + ", cannot be had: " + why +
                           "; TMPDIR may name another place for it");
}

/// A descriptor of the folder, with the lock on it; −1 and errno: EWOULDBLOCK when another process has it, ESTALE when
/// that has removed it meanwhile.
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

/// By who has the lock. A service that is being killed may still make a file in it, so first what makes it a memory.
void remove_locked(const fs::path& path) {
  std::error_code ignored;
  fs::remove(path / kOrigin, ignored);
  fs::remove_all(path, ignored);
}

/// Not when a process has it.
void remove_unlocked(const fs::path& path) {
  const int folder = open_locked(path);
  if (folder < 0) return;
  remove_locked(path);
  ::close(folder);
}

std::string read(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

RunFolder::RunFolder(const RunName& run, const std::string& origin, bool anew) : path_(folder_of(run)) {
  take(run);
  try {
    begin(origin, anew);
  } catch (...) {
    give_back();
    throw;
  }
  remove_abandoned();
}

RunFolder::RunFolder(RunFolder&& other) noexcept
    : path_(std::move(other.path_)),
      folder_(std::exchange(other.folder_, -1)),
      goes_on_(other.goes_on_),
      forgot_(other.forgot_),
      kept_(other.kept_) {}

RunFolder::~RunFolder() {
  if (folder_ >= 0) give_back();
}

void RunFolder::give_back() {
  if (!kept_) remove_locked(path_);
  ::close(folder_);
}

void RunFolder::take(const RunName& run) {
  for (int look = 0; look < kLooks; ++look) {
    if (::mkdir(path_.c_str(), 0700) != 0 && errno != EEXIST) cannot_be_had(path_, std::strerror(errno));
    // Where everybody may make folders, anybody may have made this one, and would decide what we remember.
    if (!is_ours(path_)) cannot_be_had(path_, "it is somebody else's");
    folder_ = open_locked(path_);
    if (folder_ >= 0) return;
    if (errno != EWOULDBLOCK && errno != ESTALE && errno != ENOENT) cannot_be_had(path_, std::strerror(errno));
    ::poll(nullptr, 0, kBetweenLooks);
  }
  throw std::runtime_error("host " + run.host + " of cell " + run.cell + " in DDS domain " +
                           std::to_string(run.domain) + " has an agent on this machine already: it keeps " +
                           path_.string());
}

void RunFolder::begin(const std::string& origin, bool anew) {
  const fs::path file = path_ / kOrigin;
  const bool was_used = !fs::is_empty(path_);
  goes_on_ = !anew && read(file) == origin;
  kept_ = goes_on_;
  if (!goes_on_) {
    forgot_ = was_used && !anew;
    fs::remove(file);  // first: whoever is interrupted here must not leave half of a memory that has an origin
    for (const auto& entry : fs::directory_iterator(path_)) fs::remove_all(entry.path());
    std::ofstream written(file, std::ios::binary);
    written << origin;
    if (!written.flush()) cannot_be_had(path_, std::strerror(errno));
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
    if (!name.starts_with(kPrefix) || name.find(kBeforeHost) == std::string::npos || !is_ours(entry.path())) continue;
    struct stat about {};
    if (::stat(entry.path().c_str(), &about) != 0) continue;
    if (std::time(nullptr) - about.st_mtim.tv_sec < std::chrono::seconds(kAbandoned).count()) continue;
    remove_unlocked(entry.path());
  }
}

void remove_run(const RunName& run) {
  remove_unlocked(folder_of(run));
}

}  // namespace hecaton::services
