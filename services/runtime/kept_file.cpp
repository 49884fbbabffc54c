#include "services/runtime/kept_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

/// Room is taken in pieces of this size, and there is always some to spare.
constexpr std::size_t kRoom = 1U << 16U;

class File {
 public:
  explicit File(const std::string& path)
      : descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH)) {}
  ~File() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  [[nodiscard]] std::size_t size() const {
    struct stat known {};
    return ::fstat(descriptor_, &known) == 0 ? static_cast<std::size_t>(known.st_size) : 0;
  }
  /// errno's value, 0: it has so much room now, and never less than before.
  [[nodiscard]] int reserve(std::size_t size) const {
    int error = 0;
    do {
      error = ::posix_fallocate(descriptor_, 0, static_cast<off_t>(size));
    } while (error == EINTR);
    return error;
  }
  /// errno's value, 0: all of it is there.
  [[nodiscard]] int write(const std::string& contents) const {
    for (std::size_t at = 0; at < contents.size();) {
      const ssize_t wrote = ::pwrite(descriptor_, contents.data() + at, contents.size() - at, static_cast<off_t>(at));
      if (wrote == 0) return EIO;
      if (wrote < 0 && errno != EINTR) return errno;
      if (wrote > 0) at += static_cast<std::size_t>(wrote);
    }
    return 0;
  }

 private:
  int descriptor_;
};

/// Writes the contents over what the file held. errno's value, 0: all of it is there.
int fill(const std::string& path, std::string& contents, char padding) {
  const File file(path);
  if (!file.is_open()) return errno;
  contents.resize(std::max((contents.size() / kRoom + 1) * kRoom, file.size()), padding);
  const int error = file.reserve(contents.size());
  return error != 0 ? error : file.write(contents);
}

/// errno's value, 0: `path` has now what `next` had.
int put_in_place(const std::string& next, const std::string& path) {
  if (::renameat2(AT_FDCWD, next.c_str(), AT_FDCWD, path.c_str(), RENAME_EXCHANGE) == 0) return 0;
  // The first time, or a file system that cannot exchange.
  return std::rename(next.c_str(), path.c_str()) == 0 ? 0 : errno;
}

}  // namespace

std::string other_file_of(const std::string& path) {
  return path + ".next";
}

std::string keep_in_file(const std::string& path, std::string contents, char padding) {
  const std::string next = other_file_of(path);
  int error = fill(next, contents, padding);
  if (error == 0) error = put_in_place(next, path);
  if (error != 0) return path + " cannot be written: " + std::generic_category().message(error);
  // For the next time, as long as there is room at all: where there is none it is asked for again then.
  if (const File other(next); other.is_open() && other.size() < contents.size()) {
    static_cast<void>(other.reserve(contents.size()));
  }
  return {};
}

}  // namespace hecaton::services
