#include "services/bus/mailbox.hpp"

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

namespace hecaton::bus {

bool EndpointId::same_participant(const EndpointId& other) const {
  constexpr std::size_t kPrefix = 12;
  return std::equal(bytes.begin(), bytes.begin() + kPrefix, other.bytes.begin());
}

std::string EndpointId::text() const {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  text.reserve(2 * bytes.size());
  for (const auto byte : bytes) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

Mailbox::Mailbox() : fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (fd_ < 0) throw std::system_error(errno, std::generic_category(), "bus: cannot create a mailbox (eventfd)");
}

Mailbox::~Mailbox() {
  ::close(fd_);
}

bool Mailbox::wait(Clock::duration timeout) {
  const auto until = Clock::now() + timeout;
  while (true) {
    std::uint64_t count = 0;
    if (::read(fd_, &count, sizeof count) == sizeof count) return true;
    const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
    if (left <= 0) return false;
    const timespec limit{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
    pollfd readable{fd_, POLLIN, 0};
    ::ppoll(&readable, 1, &limit, nullptr);
  }
}

void Mailbox::notify() {
  const std::uint64_t one = 1;
  // Fails only when the counter is full, and the mailbox is readable then.
  [[maybe_unused]] const auto written = ::write(fd_, &one, sizeof one);
}

std::vector<Event> Mailbox::take_events() {
  const std::scoped_lock lock(mutex_);
  std::vector<Event> events(std::make_move_iterator(events_.begin()), std::make_move_iterator(events_.end()));
  events_.clear();
  return events;
}

void Mailbox::post(Event event) {
  {
    const std::scoped_lock lock(mutex_);
    if (events_.size() == kCapacity) events_.pop_front();
    events_.push_back(std::move(event));
  }
  notify();
}

}  // namespace hecaton::bus
