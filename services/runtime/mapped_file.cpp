#include "services/runtime/mapped_file.hpp"

#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

/// errno's value, 0 when it has the size now.
int reserve(int file, off_t size) {
  if (::ftruncate(file, size) != 0) return errno;
  return ::posix_fallocate(file, 0, size);
}

}  // namespace

MappedFile::MappedFile(const std::string& path, std::size_t size, const std::string& what) : size_(size) {
  if (path.empty()) return;
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  int error = file < 0 ? errno : reserve(file, static_cast<off_t>(size));
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
