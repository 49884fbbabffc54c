#include "services/runtime/shutdown.hpp"

#include <atomic>
#include <csignal>

#include <unistd.h>

#include "services/bus/mailbox.hpp"
#include "services/runtime/first_signal.hpp"

namespace hecaton::services {
namespace {

std::atomic<bool> stop_requested{false};
std::atomic<bool> second_ends{false};
std::atomic<bus::Mailbox*> to_wake{nullptr};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<bus::Mailbox*>::is_always_lock_free,
              "a signal handler may use lock-free atomics only");

void on_signal(int number) {
  const auto arrival = first_signal::arrived(number);
  if (arrival == first_signal::Arrival::kSecond && second_ends.load()) _exit(first_signal::exit_code(number));
  stop_requested.store(true);
  if (bus::Mailbox* mailbox = to_wake.load()) mailbox->notify();
}

void handle(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

}  // namespace

ShutdownSignal::ShutdownSignal(Second second) {
  stop_requested.store(false);
  first_signal::forget();
  second_ends.store(second == Second::kEndsProcess);
  handle(SIGTERM, on_signal);
  handle(SIGINT, on_signal);
  handle(SIGPIPE, SIG_IGN);
}

ShutdownSignal::~ShutdownSignal() {
  handle(SIGTERM, SIG_DFL);
  handle(SIGINT, SIG_DFL);
  to_wake.store(nullptr);
}

bool ShutdownSignal::requested() const {
  return stop_requested.load();
}

int ShutdownSignal::signal() const {
  return first_signal::number();
}

void ShutdownSignal::wake(bus::Mailbox* mailbox) {
  to_wake.store(mailbox);
}

void ShutdownSignal::request() {
  on_signal(0);
}

}  // namespace hecaton::services
