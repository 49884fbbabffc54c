#include "services/view/token_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <string_view>

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

namespace hecaton::services {
namespace {

constexpr std::size_t kTokenBytes = 32;
constexpr std::string_view kDigits = "0123456789abcdef";
constexpr mode_t kOwnerOnly = 0600;

/// A file descriptor.
class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw std::runtime_error("the file for the token of the page, " + path.string() + ", cannot be written: " +
                           std::strerror(error) + "; without it no page can control the cell");
}

}  // namespace

std::string random_token() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw std::runtime_error("the kernel gives no random numbers for the token of the page");
  }
  std::string token;
  for (const unsigned char byte : bytes) {
    token += kDigits[byte >> 4U];
    token += kDigits[byte & 15U];
  }
  return token;
}

bool same_token(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference =
        static_cast<unsigned char>(difference | (static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i])));
  }
  return difference == 0;
}

std::optional<std::string> token_in_file(const std::filesystem::path& path, std::string_view marker) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK));
  struct stat about {};
  if (file.number() < 0 || ::fstat(file.number(), &about) != 0 || !S_ISREG(about.st_mode) ||
      about.st_uid != ::geteuid() || (about.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
    return std::nullopt;
  }
  std::array<char, 512> bytes{};
  const ssize_t count = ::read(file.number(), bytes.data(), bytes.size());
  const std::string_view text(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  const std::size_t at = text.find(marker);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view token = text.substr(at + marker.size(), 2 * kTokenBytes);
  if (token.size() != 2 * kTokenBytes || token.find_first_not_of(kDigits) != std::string_view::npos)
    return std::nullopt;
  return std::string(token);
}

void write_token_file(const std::filesystem::path& path, const std::string& url) {
  const std::string next = path.string() + ".new";
  ::unlink(next.c_str());
  const std::string line = url + "\n";
  {
    const Descriptor file(::open(next.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kOwnerOnly));
    if (file.number() < 0 || ::fchmod(file.number(), kOwnerOnly) != 0) fail(path, errno);
    if (::write(file.number(), line.data(), line.size()) != static_cast<ssize_t>(line.size())) fail(path, errno);
  }
  if (::rename(next.c_str(), path.c_str()) != 0) fail(path, errno);
}

}  // namespace hecaton::services
