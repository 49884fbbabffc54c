#include "services/config/this_machine.hpp"

#include <cerrno>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace hecaton::config {
namespace {

/// A socket can be bound to the machine's own addresses only.
bool is_own(in_addr address) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr = address;
  const bool foreign =
      ::bind(socket, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0 && errno == EADDRNOTAVAIL;
  if (socket >= 0) ::close(socket);
  return !foreign;
}

}  // namespace

bool is_this_machine(const CellFile& file, const std::string& host) {
  if (file.hosts.size() < 2) return true;
  for (const Host& one : file.hosts) {
    in_addr address{};
    if (one.name == host) return ::inet_pton(AF_INET, one.address.c_str(), &address) == 1 && is_own(address);
  }
  return false;
}

}  // namespace hecaton::config
