#include "services/runtime/atomic_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

/// Room on the disk is reserved in pieces of this size [byte], with some to spare.
constexpr std::size_t kRoom = 1U << 16U;

class File {
 public:
  explicit File(const std::string& path)
      : descriptor_(::open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR)) {}
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
  /// Never shrinks the file. Returns errno's value; 0: done.
  [[nodiscard]] int reserve(std::size_t size) const {
    int error = 0;
    do {
      error = ::posix_fallocate(descriptor_, 0, static_cast<off_t>(size));
    } while (error == EINTR);
    return error;
  }
  /// Returns errno's value; 0: all is written.
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

/// Overwrites the file at `path`, padding included. Returns errno's value; 0: all is written.
int fill(const std::string& path, std::string& contents, char padding) {
  const File file(path);
  if (!file.is_open()) return errno;
  contents.resize(std::max((contents.size() / kRoom + 1) * kRoom, file.size()), padding);
  const int error = file.reserve(contents.size());
  return error != 0 ? error : file.write(contents);
}

/// Moves `spare` to `path`. Returns errno's value; 0: done.
int put_in_place(const std::string& spare, const std::string& path) {
  if (::renameat2(AT_FDCWD, spare.c_str(), AT_FDCWD, path.c_str(), RENAME_EXCHANGE) == 0) return 0;
  // `path` does not exist yet, or the file system cannot exchange.
  return std::rename(spare.c_str(), path.c_str()) == 0 ? 0 : errno;
}

/// Returns errno's value; 0: the file has the size and its room.
int resize(int file, off_t size) {
  if (::ftruncate(file, size) != 0) return errno;
  return ::posix_fallocate(file, 0, size);
}

}  // namespace

std::string spare_file_of(const std::string& path) {
  return path + ".next";
}

std::optional<std::string> write_atomically(const std::string& path, std::string contents, char padding) {
  const std::string spare = spare_file_of(path);
  int error = fill(spare, contents, padding);
  if (error == 0) error = put_in_place(spare, path);
  if (error != 0) return path + " cannot be written: " + std::generic_category().message(error);
  // Reserves room for the next write. Without room now, that write asks for it again.
  if (const File other(spare); other.is_open() && other.size() < contents.size()) {
    static_cast<void>(other.reserve(contents.size()));
  }
  return std::nullopt;
}

MappedFile::MappedFile(const std::string& path, std::size_t size, const std::string& what) : size_(size) {
  if (path.empty()) return;
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  int error = file < 0 ? errno : resize(file, static_cast<off_t>(size));
  if (error == 0) {
    void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
    error = memory == MAP_FAILED ? errno : 0;
    if (error == 0) data_ = memory;
  }
  if (file >= 0) ::close(file);
  if (error != 0) throw std::runtime_error(path + ": " + what + " cannot be kept there: " + std::strerror(error));
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(data_, size_);
}

}  // namespace hecaton::services
